"""`nav --offline`: it says where the robot of a log was, and refuses bad inputs in one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.files.maps import save_map
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from bringup import cli
from bringup.cli_parser import parse
from tests.core.bags.recordings import SCAN, TF, Entry, scan_bytes, transform_bytes, write_humble
from tests.slam.amcl.room import Robot, ranges_at, room_map


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    """A robot at the end of a drive that is logged in room.clf, with its map room.yaml."""
    robot = Robot(np.random.default_rng(3))
    lines = []
    for k in range(60):
        robot.step()
        ranges = " ".join(f"{r:.3f}" for r in ranges_at(robot.pose, 720)[180:540])
        odometry = " ".join(f"{v:.6f}" for v in robot.odometry.array())
        lines.append(
            f"FLASER 360 {ranges} {odometry} {odometry} {0.1 * k:.3f} here {0.1 * k:.3f}\n"
        )
    (tmp_path / "room.clf").write_text("".join(lines))
    save_map(room_map(), tmp_path / "room")
    return robot


def run(folder: Path, *options: str, log: str = "room.clf", map_name: str = "room.yaml") -> int:
    paths = ["--offline", str(folder / log), "--map", str(folder / map_name)]
    return cli.run(parse(["nav", *paths, "--out", str(folder / "out"), *options]))


def test_a_log_on_a_map_becomes_a_trajectory_a_report_and_a_picture(
    robot: Robot, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(tmp_path) == 0
    assert "60 tracking" in capsys.readouterr().out
    rows = [line.split() for line in (tmp_path / "out/trajectory.tum").read_text().splitlines()]
    assert len(rows) == 60
    assert SE2(float(rows[-1][1]), float(rows[-1][2])).distance(robot.pose) < 0.05
    report = json.loads((tmp_path / "out/report.json").read_text())
    assert report["scans_by_status"] == {"tracking": 60}
    assert report["quality"] > 0.9
    assert (tmp_path / "out/plot.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_log_gives_the_same_bytes(robot: Robot, tmp_path: Path) -> None:
    traces = []
    for _ in range(2):
        run(tmp_path, "--seed", "4")
        traces.append((tmp_path / "out/trajectory.tum").read_bytes())
    assert traces[0] == traces[1]


@pytest.mark.parametrize(
    ("log", "map_name", "problem"),
    [
        ("no.clf", "room.yaml", "no.clf: does not exist"),
        ("room.clf", "no.yaml", "no.yaml"),
        ("room.clf", "blank.yaml", "has no occupied cell"),
    ],
)
def test_a_bad_input_is_refused_in_one_line(
    robot: Robot,
    tmp_path: Path,
    log: str,
    map_name: str,
    problem: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    blank = room_map()
    blank.data[:] = 0
    save_map(blank, tmp_path / "blank")
    assert run(tmp_path, log=log, map_name=map_name) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert problem in line


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_with_the_definitions_of_humble_is_followed(
    robot: Robot, storage: str, tmp_path: Path
) -> None:
    log = list(open_log(tmp_path / "room.clf", RecordingTopics()))
    messages: list[Entry] = []
    for scan, pose in log:
        moved = transform_bytes(("odom", "base_footprint", pose, scan.stamp))
        messages.append(("/tf", TF, scan.stamp, moved))
        finite = replace(scan, ranges=np.nan_to_num(scan.ranges, posinf=1e3))
        messages.append(("/scan", SCAN, scan.stamp, scan_bytes(finite)))
    write_humble(tmp_path / "bag", messages, storage)
    assert run(tmp_path, log="bag") == 0
    rows = (tmp_path / "out/trajectory.tum").read_text().splitlines()
    x, y = (float(word) for word in rows[-1].split()[1:3])
    assert SE2(x, y).distance(robot.pose) < 0.05
