"""Recordings and logs mapped offline."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.bags.decoder import DecodeError
from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import open_log, read_carmen
from arjuna_slam.logs.recording import RecordingTopics, odometry_of, scan_of, transforms_of
from arjuna_slam.offline import evaluate, map_log, read_relations, run
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam
from tests.core.bags.recordings import (
    ODOMETRY,
    SCAN,
    TF,
    Entry,
    decoded,
    odometry_bytes,
    scan_bytes,
    transform_bytes,
    write,
)
from tests.slam.slam_room import drive, ranges_at, room

LOG = drive(seed=3, laps=0.1)
MOUNT = ("base_footprint", "laser", SE2(0.2, 0.0, 0.1), 0.0)


def entries(tf: bool = True, odometry: bool = False, mount: bool = True) -> list[Entry]:
    """A drive in which each scan comes before the odometry at its stamp."""
    result: list[Entry] = []
    if mount:
        result.append(("/tf_static", TF, 0.0, transform_bytes(MOUNT)))
    for scan, pose, _ in LOG:
        stamp = scan.stamp
        result.append(("/scan", SCAN, stamp, scan_bytes(scan)))
        if tf:
            moved = transform_bytes(("/odom", "base_footprint", pose, stamp))
            result.append(("/tf", TF, stamp, moved))
        if odometry:
            result.append(("/odom", ODOMETRY, stamp, odometry_bytes(pose, stamp)))
    return result


def pairs_of(path: Path, scan: str = "", odometry: str = "") -> list[tuple[object, SE2]]:
    return [(scan, pose) for scan, pose in open_log(path, RecordingTopics(scan, odometry))]


def test_messages_are_read_in_either_byte_order() -> None:
    scan = LOG[0][0]
    for order in ("<", ">"):
        read, frame = scan_of(decoded(SCAN, scan_bytes(scan, "/lidar", order)))
        assert frame == "lidar"
        assert read.stamp == scan.stamp
        assert read.angle_increment == pytest.approx(scan.angle_increment)
        np.testing.assert_allclose(read.ranges, scan.ranges, rtol=1e-6)
    pose = odometry_of(decoded(ODOMETRY, odometry_bytes(SE2(1.0, -2.0, 0.5), 12.25)))
    assert (pose.stamp, pose.parent, pose.child) == (12.25, "odom", "base_link")
    assert pose.transform.distance(SE2(1.0, -2.0, 0.5)) < 1e-12
    assert pose.transform.theta == pytest.approx(0.5)
    both = transforms_of(decoded(TF, transform_bytes(MOUNT, ("a", "b", SE2(), 3.0))))
    assert [item.child for item in both] == ["laser", "b"]


@pytest.mark.parametrize(("tf", "odometry"), [(True, False), (False, True), (True, True)])
def test_scans_get_their_odometry_and_mount(tmp_path: Path, tf: bool, odometry: bool) -> None:
    log = open_log(write(tmp_path / "a.mcap", entries(tf, odometry)), RecordingTopics())
    pairs = list(log)
    assert len(pairs) == len(LOG)
    for (scan, pose), (_, truth, _) in zip(pairs, LOG, strict=True):
        assert pose.distance(truth) < 1e-9
        assert scan.T_base_sensor.distance(MOUNT[2]) < 1e-9
    assert log.problems == []
    assert log.progress == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("moving", [False, True])
def test_the_base_is_the_odometrys_own_where_tf_has_no_other(tmp_path: Path, moving: bool) -> None:
    topic = "/tf" if moving else "/tf_static"
    mount = topic, TF, 0.5, transform_bytes(("base_link", *MOUNT[1:]))
    every = [*entries(False, True, mount=False), mount]
    log = open_log(write(tmp_path / "a.mcap", every), RecordingTopics())
    for scan, _ in log:
        assert scan.T_base_sensor.distance(MOUNT[2]) < 1e-9
    assert log.problems == []


def test_an_odometry_topic_asked_for_wins_over_tf(tmp_path: Path) -> None:
    wrong = [
        (topic, kind, stamp, transform_bytes(("odom", "base_footprint", SE2(9.0), stamp)))
        if topic == "/tf"
        else (topic, kind, stamp, data)
        for topic, kind, stamp, data in entries(True, True)
    ]
    path = write(tmp_path / "a.mcap", wrong)
    assert pairs_of(path)[5][1].x == 9.0
    assert pairs_of(path, odometry="/odom")[5][1].distance(LOG[5][1]) < 1e-9


def test_a_recording_becomes_the_trajectory_that_was_driven(tmp_path: Path) -> None:
    mount = [entry for entry in entries() if entry[0] != "/tf_static"]
    level = ("base_footprint", "laser", SE2(), 0.0)
    mount.insert(0, ("/tf_static", TF, 0.0, transform_bytes(level)))
    trajectory = run(Slam(), open_log(write(tmp_path / "a.mcap", mount), RecordingTopics()))
    end = LOG[0][2].inverse() @ LOG[-1][2]
    assert len(trajectory) == len(LOG)
    assert trajectory[-1][1].distance(end) < 0.02


def test_a_scan_without_odometry_at_its_stamp_is_counted(tmp_path: Path) -> None:
    early = [("/scan", SCAN, 0.0, scan_bytes(LOG[k][0])) for k in range(3)]
    path = write(tmp_path / "a.mcap", early + entries()[7:])
    log = open_log(path, RecordingTopics())
    assert len(list(log)) < len(LOG)
    assert "scans have no odometry at their stamp" in " ".join(log.problems)
    assert "nothing says where 'laser' is" in " ".join(log.problems)


def test_a_rosbag2_folder_is_read_in_the_order_of_its_metadata(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    bag.mkdir()
    every = entries()
    write(bag / "z.mcap", every[:41])
    write(bag / "a.mcap", every[41:])
    (bag / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {relative_file_paths: [z.mcap, a.mcap]}"
    )
    assert len(pairs_of(bag)) == len(LOG)
    (bag / "metadata.yaml").write_text("rosbag2_bagfile_information: 3")
    with pytest.raises(InputFileError, match="is no metadata of rosbag2"):
        pairs_of(bag)


@pytest.mark.parametrize(
    ("topics", "message"),
    [
        (RecordingTopics(scan="/front"), "no topic '/front' of sensor_msgs.*valid: /scan"),
        (RecordingTopics(odometry="/odom"), "no topic '/odom' of nav_msgs.*valid: none"),
        (
            RecordingTopics(base_frame="base"),
            "has no topic of nav_msgs/msg/Odometry.*'odom' and 'base'.*--base-frame",
        ),
    ],
)
def test_what_is_not_there_is_named_with_what_is(
    tmp_path: Path, topics: RecordingTopics, message: str
) -> None:
    path = write(tmp_path / "a.mcap", entries())
    with pytest.raises(InputFileError, match=message):
        list(open_log(path, topics))


def test_files_that_are_no_recordings_are_refused(tmp_path: Path) -> None:
    text = tmp_path / "a.mcap"
    text.write_text("no recording at all")
    with pytest.raises(InputFileError, match="is no mcap recording"):
        pairs_of(text)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputFileError, match="holds no recording"):
        pairs_of(tmp_path / "empty")
    with pytest.raises(InputFileError, match="does not exist"):
        pairs_of(tmp_path / "no.mcap")
    other = text.rename(tmp_path / "a.txt")
    with pytest.raises(InputFileError, match=r"of no kind that can be read; valid: \.clf"):
        pairs_of(other)
    other = write(tmp_path / "other.mcap", entries(), encoding="json")
    with pytest.raises(InputFileError, match="encoded as 'json'; valid: cdr"):
        pairs_of(other)
    empty = write(tmp_path / "none.mcap", [("/map", "nav_msgs/msg/OccupancyGrid", 0.0, b"")])
    with pytest.raises(InputFileError, match=r"no topic of sensor_msgs.*its topics: /map"):
        pairs_of(empty)


def test_a_lidar_mounted_upside_down_sees_the_same_room(tmp_path: Path) -> None:
    every = entries(mount=False)
    inverted = transform_bytes(MOUNT, upside_down=True)
    every.insert(0, ("/tf_static", TF, 0.0, inverted))
    for (scan, _), (level, _, _) in zip(
        open_log(write(tmp_path / "a.mcap", every), RecordingTopics()), LOG, strict=True
    ):
        assert scan.angle_increment == pytest.approx(-level.angle_increment)
        assert scan.angle_min == pytest.approx(-level.angle_min)
        assert scan.T_base_sensor.distance(MOUNT[2]) < 1e-9
        assert scan.T_base_sensor.theta == pytest.approx(MOUNT[2].theta)


@pytest.mark.parametrize("cut", [0, 3, 10, 30, 60, 100])
def test_a_message_cut_short_is_an_error_and_no_guess(cut: int) -> None:
    with pytest.raises(DecodeError, match=r"CDR encapsulation|not deserialize|Invalid sequence"):
        decoded(SCAN, scan_bytes(LOG[0][0])[:cut])


def test_a_count_of_billions_is_refused_before_it_is_believed() -> None:
    data = bytearray(scan_bytes(LOG[0][0]))
    at = data.index(np.float32(LOG[0][0].ranges[0]).tobytes()) - 4
    data[at : at + 4] = b"\xff\xff\xff\xff"
    with pytest.raises(DecodeError, match="Invalid sequence length"):
        decoded(SCAN, bytes(data))


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


def test_a_replayed_log_meets_its_relations_and_a_stamp_that_steps_back_is_used() -> None:
    trajectory = run(Slam(), read_carmen(text()))
    assert len(trajectory) == 20
    relations = np.array([(100.0, 110.0, 1.0, 0, 0, 0, 0, 0), (104.0, 119.0, 1.5, 0, 0, 0, 0, 0)])
    result = evaluate(trajectory, relations)
    assert result.count == 2
    assert result.translation[0] < 0.01
    assert result.rotation[0] < 0.003


# 20 scans, each second and 0.1 m, one of them stamped 1.5 s before the one ahead of it
@pytest.mark.parametrize(
    ("values", "count"),
    [
        ({"minimum_time_interval": 0.0}, 20),
        ({"minimum_time_interval": 0.0, "throttle_scans": 3}, 7),
        ({"minimum_time_interval": 0.0, "process_between_keyframes": False}, 4),
        ({"minimum_time_interval": 2.0}, 11),
    ],
)
def test_a_log_is_mapped_at_the_pace_of_the_parameters(
    values: dict[str, object], count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, mapped, process = tmp_path / "drive.clf", list[Scan](), Slam.process

    def counted(slam: Slam, scan: Scan, T_odom_base: SE2) -> SlamUpdate | None:
        mapped.append(scan)
        return process(slam, scan, T_odom_base)

    monkeypatch.setattr(Slam, "process", counted)
    file.write_text("".join(text()), encoding="utf-8")
    assert len(map_log(file, values).trajectory) == 20
    assert len(mapped) == count


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
