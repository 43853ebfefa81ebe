"""Recordings run offline through SLAM, AMCL and calibration."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.grid import OCCUPIED
from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from bringup import cli
from bringup.cli import REFUSED, parse
from bringup.offline.calibration import write_calibration
from bringup.parameters.files import for_node, load_parameters
from bringup.terminal import Bar
from tests.core.bags.recordings import (
    SCAN,
    TF,
    Entry,
    scan_bytes,
    transform_bytes,
    write,
    write_humble,
)
from tests.slam.amcl.room import Robot, ranges_at, room_map
from tests.slam.logs.test_recording import LOG, entries, text


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "room.clf"
    path.write_text("".join(text()))
    return path


def test_a_log_becomes_map_trajectory_report_and_picture(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    relations = tmp_path / "room.relations"
    relations.write_text("100.0 110.0 1.0 0 0 0 0 0\n")
    out = tmp_path / "out"
    argv = ["slam", "--offline", str(log), "--out", str(out), "--relations", str(relations)]
    assert cli.run(parse(argv)) == 0
    assert "relations" in capsys.readouterr().out
    report = json.loads((out / "report.json").read_text())
    assert (report["scans"], report["scans_skipped"], report["log_s"]) == (20, 0, 19.0)
    assert report["relations"]["translation_m"] < 0.01
    assert (load_map(out / "map.yaml").data == 100).sum() > 100
    rows = [line.split() for line in (out / "trajectory.tum").read_text().splitlines()]
    assert {len(row) for row in rows} == {8}
    assert float(rows[-1][1]) == pytest.approx(4.9, abs=0.02)  # odometry begins at 3 m
    assert (out / "plot.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.ros
@pytest.mark.parametrize(("strict", "code"), [([], 0), (["--strict"], 2)])
def test_a_parameter_file_is_read_by_the_rule_of_all_commands(
    log: Path, strict: list[str], code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rclpy", reason="no ROS here")
    file, out = log.with_name("own.yaml"), str(log.parent / "out")
    file.write_text("slam_toolbox: {ros__parameters: {resolutoin: 0.1}}\n", encoding="utf-8")
    argv = ["slam", "--offline", str(log), "--out", out, "--params", str(file), *strict]
    assert cli.run(parse(argv)) == code
    assert "unknown: slam_toolbox: resolutoin" in capsys.readouterr().err


def test_a_bar_that_nobody_watches_says_each_tenth_once(capsys: pytest.CaptureFixture[str]) -> None:
    bar = Bar(sys.stderr)
    for k in range(101):
        bar.show(k / 100.0, f"{k} scans")
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[0] == " 10 %  10 scans"


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP", "bare"])
def test_a_bag_with_the_definitions_of_humble_becomes_a_map(storage: str, tmp_path: Path) -> None:
    kind = "SQLITE3" if storage == "bare" else storage
    bag = write_humble(tmp_path / "bag", entries(), kind)
    path = bag / "bag.db3" if storage == "bare" else bag
    assert cli.run(parse(["slam", "--offline", str(path), "--out", str(tmp_path / "out")])) == 0
    report = json.loads((tmp_path / "out/report.json").read_text())
    assert (report["scans"], report["scans_skipped"]) == (len(LOG), 0)


def test_frames_are_those_of_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "a.mcap", entries())
    argv = ["slam", "--offline", str(path), "--out", str(tmp_path / "out"), "--base-frame", "base"]
    assert cli.run(parse(argv)) == REFUSED
    assert "no transform connects 'odom' and 'base'" in capsys.readouterr().err


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


def run(folder: Path, *options: str, log: str = "room.clf") -> int:
    paths = ["--offline", str(folder / log), "--map", str(folder / "room.yaml")]
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
    ("words", "problem"),
    [
        ("slam --offline no.clf", "no.clf: does not exist"),
        (
            "slam --offline room.clf --relations no.relations",
            "no.relations: cannot be read: No suc",
        ),
        ("slam --offline room.clf --out room.clf/out", "cannot be written: Not a directory"),
        ("slam --offline room.clf --params no.yaml", "no.yaml"),
        ("nav --offline no.clf --map room.yaml", "no.clf: does not exist"),
        ("nav --offline room.clf --map no.yaml", "no.yaml"),
        ("nav --offline room.clf --map blank.yaml", "has no free cell"),
    ],
)
def test_a_bad_input_is_refused_in_one_line(
    words: str,
    problem: str,
    robot: Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    blank = room_map()
    blank.data[:] = OCCUPIED
    save_map(blank, tmp_path / "blank")
    assert cli.run(parse(words.split())) == REFUSED
    (line,) = capsys.readouterr().err.splitlines()
    assert problem in line


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_with_humbles_definitions_is_read(robot: Robot, storage: str, tmp_path: Path) -> None:
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


def test_calibrate_writes_parameters_a_snippet_and_a_picture(tmp_path: Path) -> None:
    out = tmp_path / "new" / "folder"
    report = write_calibration(None, None, out)
    assert "within 2% and 4%: yes" in report
    values = for_node(load_parameters([out / "calibration.yaml"]), "sim")
    config = load(SimulatorConfig, values, "sim")
    assert config.drive.effective_track_width == pytest.approx(0.603, rel=0.01)
    assert config.odometry.angular_noise > 0.0
    assert "<effectiveTrackWidth>0.6" in (out / "calibration.urdf.xml").read_text()
    assert (out / "calibration.png").read_bytes().startswith(b"\x89PNG")


def test_a_missing_robot_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "no.urdf"
    code = cli.run(parse(["calibrate", "--robot", str(missing), "--out", str(tmp_path)]))
    assert code == REFUSED
    assert "no.urdf" in capsys.readouterr().err
