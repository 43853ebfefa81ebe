"""Claims: scans are the same from every storage; damage raises only the reader's own error."""

from __future__ import annotations

import bz2
import gzip
import lzma
import math
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.ros.health.rules import GREATEST
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import CarmenLog, open_log, read_carmen
from arjuna_slam.logs.recording import RecordingTopics
from tests.core.bags.recordings import write, write_humble, write_ros1
from tests.slam.logs.test_recording import LOG, entries

MOUNT = "0.25 0.0 0.0 0.0 0.0 0.0"  # the laser's pose and the robot's


def flaser(ranges: list[float], poses: str = MOUNT, stamp: str = "12.5") -> str:
    values = " ".join(str(r) for r in ranges)
    return f"FLASER {len(ranges)} {values} {poses} {stamp} host 0.5\n"


def robotlaser(ranges: list[float], range_max: str, remissions: int, poses: str = MOUNT) -> str:
    values, more = " ".join(str(r) for r in ranges), " ".join(["9"] * remissions)
    head = f"ROBOTLASER1 0 -0.7 1.4 0.35 {range_max} 0.01 0 {len(ranges)} {values}"
    return f"{head} {remissions} {more} {poses} 1.1 1.2 1.3 1.4 1.5 12.5 host 0.5\n"


@pytest.mark.parametrize(
    ("count", "last"), [(180, 89.0), (181, 90.0), (360, 89.5), (361, 90.0), (2, 0.0), (3, 90.0)]
)
def test_a_flaser_scan_spans_half_a_circle(count: int, last: float) -> None:
    ((scan, _),) = read_carmen([flaser([float(k) for k in range(count)])])
    assert scan.angle_min == pytest.approx(-math.pi / 2)
    assert scan.angle_min + (count - 1) * scan.angle_increment == pytest.approx(math.radians(last))
    assert scan.ranges.tolist() == [k if k < 80 else math.inf for k in range(count)]
    assert (scan.stamp, scan.range_min, scan.range_max) == (12.5, 0.02, 80.0)


def test_words_may_be_apart_by_any_white_space_and_a_bare_kind_is_a_problem() -> None:
    (scan, _), *none = read_carmen([f"  {flaser([3.0])}".replace(" ", "\t")])
    assert scan.ranges.tolist() == [3.0]
    assert not none
    problems: list[str] = []
    lines = ["FLASER\n", "ROBOTLASER1", "", "\n", "# FLASER\n"]
    assert list(read_carmen(lines, problems=problems)) == []
    missing = "the number of readings is missing; valid: a whole number"
    assert problems == [f"line 1: {missing}", f"line 2: {missing}"]


@pytest.mark.parametrize(
    ("range_max", "reach"), [("50.0", 49.99), ("0.0", 80.0), ("-1", 80.0), ("81.9", 80.0)]
)
@pytest.mark.parametrize("remissions", [0, 3])
def test_a_robotlaser_line_has_its_range(range_max: str, reach: float, remissions: int) -> None:
    ranges = [1.0, reach - 0.001, reach + 0.001]
    ((scan, odometry),) = read_carmen([robotlaser(ranges, range_max, remissions)])
    assert scan.ranges.tolist() == [1.0, reach - 0.001, math.inf]
    assert (scan.angle_min, scan.angle_increment, scan.stamp) == (-0.7, 0.35, 12.5)
    assert scan.range_max == pytest.approx(reach)
    assert odometry == SE2()
    assert scan.T_base_sensor == SE2(0.25, 0.0, 0.0)


@pytest.mark.parametrize("read", [flaser, lambda r, p: robotlaser(r, "50", 2, p)])
def test_the_poses_of_laser_and_robot_are_distinguished(read: object) -> None:
    assert callable(read)
    poses = "1.5 2.0 0.5 1.0 2.0 0.0"
    ((scan, odometry),) = read_carmen([read([1.0, 2.0], poses)])
    assert odometry == SE2(1.0, 2.0, 0.0)
    assert scan.T_base_sensor == SE2(0.5, 0.0, 0.5)


def test_the_first_line_says_where_the_laser_sits_if_it_can_be() -> None:
    lines = [flaser([1.0], "0.6 0.6 0.1 0 0 0"), flaser([1.0], "0.5 0 0 0 0 0")]
    for scan, _ in read_carmen(lines):
        assert scan.T_base_sensor.array() == pytest.approx((0.6, 0.6, 0.1))
    given = SE2(0.1, 0.2, 0.3)
    assert {scan.T_base_sensor for scan, _ in read_carmen(lines, given)} == {given}
    for far in ("0.8 0.8", "-1.0 0", "0 1.1"):  # corrected by some other program
        ((scan, _),) = read_carmen([flaser([1.0], f"{far} 0.1 0 0 0")])
        assert scan.T_base_sensor == SE2()


WHOLE = robotlaser([1.0, 2.0], "50", 1).split()
BAD = [
    ("FLASER x 1 2 3", "number of readings is x; valid: a whole number"),
    ("FLASER -1 1 2 3", "number of readings is -1;"),
    ("FLASER 1.5 1 2 3", "number of readings is 1.5;"),
    ("ROBOTLASER1 0 0 0 0 0 0 0", "number of readings is missing;"),
    (" ".join(flaser([1.0, 2.0]).split()[:-1]), "12 words, 13 are valid"),
    (" ".join(WHOLE[:-1]), "26 words, 27 are valid"),
    (" ".join(WHOLE[:11]), "number of readings is missing;"),
    (" ".join([*WHOLE[:11], "some", *WHOLE[12:]]), "number of readings is some;"),
    (flaser([1.0]).replace("1.0", "far"), "far"),
    (flaser([1.0], "nan 0 0 0 0 0"), "pose or stamp of nan 0"),
    (flaser([1.0], "0 0 0 0 inf 0"), "is not finite or too great"),
    (flaser([1.0], stamp="-inf"), "is not finite or too great"),
    (flaser([1.0], stamp=str(2.0 * GREATEST)), "is not finite or too great"),
    (robotlaser([1.0], "50", 0, "0 0 0 nan 0 0"), "is not finite or too great"),
    (robotlaser([1.0], "50", 0).replace("12.5", "nan"), "is not finite or too great"),
]


@pytest.mark.parametrize(("line", "problem"), BAD)
def test_a_line_that_cannot_be_read_is_named_and_passed_over(line: str, problem: str) -> None:
    lines = ["# said\n", flaser([1.0]), f"{line.strip()}\n", flaser([2.0])]
    with pytest.raises(ValueError, match=f"line 3: .*{problem}"):
        list(read_carmen(lines))
    problems: list[str] = []
    assert [scan.ranges[0] for scan, _ in read_carmen(lines, problems=problems)] == [1.0, 2.0]
    (said,) = problems
    assert said.startswith("line 3: ")
    assert problem in said


def test_a_log_has_the_share_that_was_read(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(flaser([1.0] * 100) * 200)
    log = CarmenLog(path)
    assert log.progress == 0.0
    shares = [log.progress for _ in log]
    assert len(shares) == 200
    assert 0.0 < shares[0] < 0.5
    assert np.all(np.diff(shares) >= 0.0)
    assert log.progress == 1.0
    assert log.problems == []
    assert len(list(log)) == 200  # once more from the beginning
    (tmp_path / "none.log").write_text("")
    none = CarmenLog(tmp_path / "none.log")
    assert none.progress == 0.0
    with pytest.raises(InputFileError, match="no line begins with FLASER"):
        list(none)


def test_a_log_that_is_not_there_or_cut_short_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match=r"cannot be read: No such file"):
        CarmenLog(tmp_path / "none.log")
    rng = np.random.default_rng(0)
    lines = [flaser(rng.uniform(1.0, 9.0, 50).tolist()).encode() for _ in range(100)]
    packings: dict[str, Callable[[bytes], bytes]]
    packings = {"a.log": bytes, "a.log.bz2": bz2.compress, "a.clf.xz": lzma.compress}
    for name, pack in packings.items():
        (tmp_path / name).write_bytes(pack(b"".join(lines)))
        assert len(list(open_log(tmp_path / name, RecordingTopics()))) == 100
    packed = gzip.compress(b"".join([b"FLASER 9\n", *lines, b"FLASER 8\n"]))
    (tmp_path / "A.LOG.GZ").write_bytes(packed[: len(packed) // 2])
    cut = CarmenLog(tmp_path / "A.LOG.GZ")
    assert 20 < len(list(cut)) < 80
    damaged, lost = sorted(cut.problems, reverse=True)
    assert damaged.startswith("damaged or cut short (")
    assert lost.startswith("1 lines could not be read; the first, line 1: 2 words")


Make = Callable[[Path], Path]


def bare(folder: Path) -> Path:
    return write_humble(folder / "bag", entries()) / "bag.db3"


def without_definitions(folder: Path) -> Path:
    path = bare(folder)
    database = sqlite3.connect(path)
    database.execute("DROP TABLE message_definitions")
    database.commit()
    database.close()
    return path


def packed(storage: str, what: str) -> Make:
    return lambda folder: write_humble(folder / "bag", entries(), storage, what)


STORED: dict[str, Make] = {
    "a rosbag2 folder in SQLite": lambda folder: write_humble(folder / "bag", entries()),
    "a bare db3": bare,
    "a db3 as Humble writes it, without definitions": without_definitions,
    "a rosbag2 folder in mcap": lambda folder: write_humble(folder / "bag", entries(), "MCAP"),
    "each message compressed, in SQLite": packed("SQLITE3", "MESSAGE"),
    "each file compressed, in SQLite": packed("SQLITE3", "FILE"),
    "each message compressed, in mcap": packed("MCAP", "MESSAGE"),
    "each file compressed, in mcap": packed("MCAP", "FILE"),
    "a compressed file alone": lambda folder: next(
        write_humble(folder / "bag", entries(), packed="FILE").glob("*.zstd")
    ),
    "a bag of ROS 1": lambda folder: write_ros1(folder / "a.bag", entries()),
}


def read(path: Path) -> tuple[list[tuple[Scan, SE2]], list[str]]:
    log = open_log(path, RecordingTopics())
    pairs = list(log)
    assert 0.0 <= log.progress <= 1.0
    return pairs, log.problems


@pytest.mark.parametrize("name", STORED)
def test_the_same_messages_are_read_from_every_storage(name: str, tmp_path: Path) -> None:
    pairs, problems = read(STORED[name](tmp_path))
    known, _ = read(write(tmp_path / "known.mcap", entries()))
    assert len(pairs) == len(LOG)
    assert problems == []
    for (scan, pose), (known_scan, known_pose) in zip(pairs, known, strict=True):
        assert pose == known_pose
        assert scan.stamp == known_scan.stamp
        assert scan.T_base_sensor == known_scan.T_base_sensor
        np.testing.assert_array_equal(scan.ranges, known_scan.ranges)


def test_a_type_that_only_has_the_name_is_refused(tmp_path: Path) -> None:
    other = b"std_msgs/Header header\nfloat64[] ranges\n"
    path = write(tmp_path / "a.mcap", entries(), definition=other)
    with pytest.raises(InputFileError, match="only has the name of sensor_msgs/msg/LaserScan"):
        read(path)
