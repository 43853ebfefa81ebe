"""`slam --offline`: what it writes, and that a bad input is one line and an exit code."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from arjuna_core.files.maps import load_map
from bringup import cli
from bringup.cli_parser import parse
from bringup.terminal import Bar
from tests.core.bags.recordings import write_humble
from tests.slam.logs.test_offline import text
from tests.slam.logs.test_recording import LOG, entries


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
    assert float(rows[-1][1]) == pytest.approx(1.9, abs=0.02)
    assert (out / "plot.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("name", "options", "problem"),
    [
        ("no.clf", [], "no.clf: does not exist"),
        ("room.clf", ["--relations", "no.relations"], "no.relations: cannot be read: No such"),
        ("room.clf", ["--out", "room.clf/out"], "cannot be written: Not a directory"),
        ("room.clf", ["--params", "no.yaml"], "no.yaml"),
    ],
)
def test_a_bad_input_is_refused_in_one_line(
    log: Path,
    name: str,
    options: list[str],
    problem: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(log.parent)
    assert cli.run(parse(["slam", "--offline", name, *options])) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert problem in line


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
