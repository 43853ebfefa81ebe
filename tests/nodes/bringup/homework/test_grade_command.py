"""`grade --students`: a class's table and pages, the same bytes, and what changed alone again."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

from tests.nodes.bringup.homework.test_grading import handed_in


def bringup(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bringup", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "outcome.json"
    }


def test_a_class_is_graded(tmp_path: Path) -> None:
    for kind in ("right", "wrong"):
        handed_in(tmp_path / "class" / kind, "kinematics", kind)
    (tmp_path / "class" / "=evil").mkdir()
    (tmp_path / "class" / "twin").symlink_to(tmp_path / "class" / "right")
    words = ["grade", "--students", str(tmp_path / "class"), "--exercise", "kinematics"]
    for name in ("one", "two"):
        assert bringup(*words, "--out", str(tmp_path / name), "--jobs", "2").returncode == 0
    assert files(tmp_path / "one") == files(tmp_path / "two")
    rows = list(csv.DictReader((tmp_path / "one" / "grades.csv").open()))
    assert {row["student"]: row["points"] for row in rows} == {
        "'=evil": "0", "right": "10", "wrong": "2",
    }  # fmt: skip
    assert "has no kinematics.py" in rows[0]["what went wrong"]
    page = (tmp_path / "one" / "right" / "index.html").read_text()
    assert "<td>10</td><td>10</td>" in page

    handed_in(tmp_path / "class" / "wrong", "kinematics", "right")
    before = (tmp_path / "one" / "right" / "outcome.json").stat().st_mtime_ns
    assert bringup(*words, "--out", str(tmp_path / "one")).returncode == 0
    rows = list(csv.DictReader((tmp_path / "one" / "grades.csv").open()))
    assert [row["points"] for row in rows] == ["0", "10", "10"]
    assert (tmp_path / "one" / "right" / "outcome.json").stat().st_mtime_ns == before


def test_the_exercise_is_found_by_what_is_handed_in(tmp_path: Path) -> None:
    handed_in(tmp_path / "mine", "square", "right")
    run = bringup("grade", str(tmp_path / "mine"), "--out", str(tmp_path / "out"))
    assert run.returncode == 0
    assert "A square of one metre: 10 of 10 points" in run.stdout
    assert (tmp_path / "out" / "path.png").stat().st_size > 10_000
    run = bringup("grade", str(tmp_path), "--out", str(tmp_path / "out"))
    assert run.returncode == 2
    assert "no known homework; say --exercise" in run.stderr
