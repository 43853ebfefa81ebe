from __future__ import annotations

import gzip
import lzma
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import open_log, read_carmen
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.logs.relations import evaluate, read_relations
from arjuna_slam.offline import run
from arjuna_slam.slam import Slam
from tests.slam.slam_room import ranges_at, room


def line(ranges: Floats, odometry: SE2, stamp: float) -> str:
    values = " ".join(f"{r:.3f}" for r in ranges)
    pose = f"{odometry.x} {odometry.y} {odometry.theta}"
    return f"FLASER {len(ranges)} {values} {pose} {pose} {stamp} host {stamp}\n"


def text() -> list[str]:
    angles = np.radians(np.arange(180) - 90.0)
    lines = ["# a comment\n", "ODOM 0 0 0 0 0 0 1.0 host 1.0\n"]
    for k in range(20):
        pose = SE2(3.0 + 0.1 * k, 5.0, 0.0)
        stamp = 100.0 + k if k != 5 else 103.5  # logged late
        lines.append(line(ranges_at(room(), pose, angles), pose, stamp))
    return lines


def test_flaser_lines_become_scans_and_odometry() -> None:
    log = list(read_carmen(text(), SE2(0.1, 0.0, 0.0)))
    scan, odometry = log[0]
    assert len(log) == 20
    assert len(scan.ranges) == 180
    assert scan.angle_min == pytest.approx(-0.5 * math.pi)
    assert scan.angle_increment == pytest.approx(math.radians(1.0))
    assert scan.T_base_sensor == SE2(0.1, 0.0, 0.0)
    assert odometry == SE2(3.0, 5.0, 0.0)


def test_a_reading_at_the_maximum_is_no_return() -> None:
    scan, _ = next(read_carmen([line(np.full(180, 81.83), SE2(), 1.0)]))
    assert np.isposinf(scan.ranges).all()


def test_a_line_cut_short_is_named() -> None:
    with pytest.raises(ValueError, match="line 2: 20 words, 191 are valid"):
        list(read_carmen(["# log\n", "FLASER 180 " + " ".join(["1"] * 18)]))


def test_a_replayed_log_meets_its_relations_and_a_stamp_that_steps_back_is_used() -> None:
    trajectory = run(Slam(), read_carmen(text()))
    assert len(trajectory) == 20
    relations = np.array([(100.0, 110.0, 1.0, 0, 0, 0, 0, 0), (104.0, 119.0, 1.5, 0, 0, 0, 0, 0)])
    result = evaluate(trajectory, relations)
    assert result.count == 2
    assert result.translation[0] < 0.01
    assert result.rotation[0] < 0.003


def test_relations_are_read_from_a_file_of_eight_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.relations"
    path.write_text("# t1 t2 x y z roll pitch yaw\n1 2 0.5 -0.1 0 0 0 0.3\n", encoding="utf-8")
    assert read_relations(path).tolist() == [[1.0, 2.0, 0.5, -0.1, 0.0, 0.0, 0.0, 0.3]]
    for text, problem in (("1 2 3\n", "has 3 columns"), ("a b\n", "cannot be read as relations")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputFileError, match=problem):
            read_relations(path)


def test_relation_errors_are_those_of_the_metric() -> None:
    trajectory = [(0.0, SE2(0.0, 0.0, math.pi / 2)), (2.0, SE2(0.0, 2.0, math.pi / 2))]
    relations = np.array([(0.0, 1.0, 1.0, 0.1, 0, 0, 0, 0.2), (0.0, 9.0, 0, 0, 0, 0, 0, 0)])
    result = evaluate(trajectory, relations)
    assert result.count == 1
    assert result.translation[0] == pytest.approx(0.1)
    assert result.rotation[0] == pytest.approx(0.2)
    both = evaluate(trajectory, np.vstack((relations[:1], [(0.0, 2.0, 2.0, 0, 0, 0, 0, 0)])))
    assert both.translation == pytest.approx((0.05, 0.05))
    assert both.rotation == pytest.approx((0.1, 0.1))


def test_no_relation_in_time_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"no relation within 0\.000"):
        evaluate([(0.0, SE2()), (1.0, SE2())], np.array([(5.0, 6.0, 0, 0, 0, 0, 0, 0)]))


def test_a_compressed_log_is_the_log(tmp_path: Path) -> None:
    data = "".join(text()).encode()
    (tmp_path / "a.clf").write_bytes(data)
    (tmp_path / "a.clf.xz").write_bytes(lzma.compress(data))
    (tmp_path / "a.log.gz").write_bytes(gzip.compress(data))
    for name in ("a.clf", "a.clf.xz", "a.log.gz"):
        log = open_log(tmp_path / name, RecordingTopics())
        assert len(list(log)) == 20
        assert log.progress > 0.9


def test_the_laser_sits_where_the_first_line_says() -> None:
    values = " ".join(["1.0"] * 180)
    odometry, laser = SE2(1.0, 2.0, 0.5), SE2(1.0, 2.0, 0.5) @ SE2(0.1, -0.04, 0.0)
    poses = f"{laser.x} {laser.y} {laser.theta} {odometry.x} {odometry.y} {odometry.theta}"
    scan, _ = next(read_carmen([f"FLASER 180 {values} {poses} 1.0 host 1.0"]))
    assert scan.T_base_sensor.distance(SE2(0.1, -0.04, 0.0)) < 1e-9


def test_robotlaser_lines_say_what_they_span() -> None:
    values = " ".join(["2.0"] * 4 + ["30.0"])
    poses = "1.1 2.0 0.0 1.0 2.0 0.0"
    line = f"ROBOTLASER1 0 -1.0 2.0 0.5 30.0 0.01 0 5 {values} 1 7 {poses} 0 0 0 0 0 9.5 host 1.0"
    scan, odometry = next(read_carmen([line]))
    assert (scan.angle_min, scan.angle_increment, scan.stamp) == (-1.0, 0.5, 9.5)
    assert np.isposinf(scan.ranges[-1])
    assert odometry == SE2(1.0, 2.0, 0.0)
    assert scan.T_base_sensor.x == pytest.approx(0.1)


def test_bad_lines_are_passed_over_and_noted(tmp_path: Path) -> None:
    lines = text()
    lines[7] = "FLASER 180 1.0 2.0\n"
    lines[9] = lines[9].replace("FLASER 180", "FLASER many")
    (tmp_path / "a.log").write_text("".join(lines))
    log = open_log(tmp_path / "a.log", RecordingTopics())
    assert len(list(log)) == 18
    assert log.problems == ["2 lines could not be read; the first, line 8: 4 words, 191 are valid"]


def test_a_log_without_scans_or_cut_in_its_compression_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text("nothing here\n")
    with pytest.raises(InputFileError, match="no line begins with FLASER or ROBOTLASER1"):
        list(open_log(tmp_path / "a.log", RecordingTopics()))
    (tmp_path / "a.clf.xz").write_bytes(b"no xz")
    with pytest.raises(InputFileError, match="damaged or cut short"):
        list(open_log(tmp_path / "a.clf.xz", RecordingTopics()))
