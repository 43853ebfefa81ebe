"""Right, wrong and hostile submissions: the points of each, twice the same, and nothing else."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.yaml_file import read_yaml
from bringup.homework.exercise import (
    Mark,
    SubmissionError,
    exercises,
    files_of,
    hand_out,
    load_exercise,
)
from bringup.homework.grading import Grade, grade
from bringup.homework.program import LostError, Program, ProtectionError
from bringup.homework.report import figures_of
from tests.helpers.extending import ROOT

KINDS = ("right", "wrong", "hostile")
_WITHOUT_NAMESPACES = (
    "from bringup.homework import sandbox, student; "
    "student.separate = lambda work, size: False; student.main()"
)


@cache
def solutions() -> dict[str, Any]:
    return dict(read_yaml(Path(__file__).with_name("solutions.yaml")))


def handed_in(folder: Path, exercise: str, kind: str) -> Path:
    """Write what a student hands in; return its folder."""
    one = solutions()[exercise][kind]
    folder.mkdir(parents=True, exist_ok=True)
    for name, source in one.get("copies", {}).items():
        (folder / name).write_bytes(shipped_file(source).read_bytes())
    for name in one.keys() - {"points", "says", "ended", "copies", "duration"}:
        (folder / name).write_text(one[name])
    return folder


def test_all_exercises_have_solutions() -> None:
    assert sorted(exercises()) == sorted(solutions())
    assert all(tuple(kinds) == KINDS for kinds in solutions().values())


@cache
def graded(name: str, kind: str) -> Grade:
    """Grade what a student hands in, for all tests that look at it."""
    with TemporaryDirectory() as folder:
        exercise = load_exercise(name)
        most = solutions()[name][kind].get("duration", exercise.duration)
        exercise = replace(exercise, duration=min(exercise.duration, most))
        found = grade(exercise, handed_in(Path(folder) / "in", name, kind))
        assert [path.name for path in Path(folder).iterdir()] == ["in"]
        return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", sorted(exercises()))
def test_a_submission_gets_its_points(name: str, kind: str) -> None:
    one, first = solutions()[name][kind], graded(name, kind)
    assert first.points == one["points"]
    assert first.ended if "ended" in one else True
    assert one.get("ended", "") in first.ended
    for criterion, text in one.get("says", {}).items():
        assert text in first.marks[criterion].why
    if kind == "right":
        assert first.points == first.exercise.points
        assert not any(mark.why for mark in first.marks.values())
    assert "DONE" not in first.printed


@pytest.mark.parametrize("name", ["kinematics", "pid"])
def test_a_function_and_a_node_get_the_same_grade_again(name: str, tmp_path: Path) -> None:
    again = grade(load_exercise(name), handed_in(tmp_path, name, "right"))
    first = graded(name, "right")
    assert figures_of(first) == figures_of(again)
    assert first.printed == again.printed


def test_what_a_hostile_program_tries_is_refused() -> None:
    """Each probe ran, and says so: a grade of 0 alone would not show it."""
    kinds = ("avoidance", "square", "waypoints")
    printed = {name: graded(name, "hostile").printed for name in kinds}
    assert printed["avoidance"].splitlines() == [
        *(
            f"{name} refused Permission denied"
            for name in ("passwords", "judges", "solutions", "write", "temporary", "home")
        ),
        "fill refused No space left on device",
    ]
    assert "service False\ntruth 0 imported []\n" in printed["square"]
    for name in ("fork", "exec", "child", "kill", "socket", "processes"):
        assert f"{name} refused PermissionError" in printed["waypoints"]


def test_landlock_and_seccomp_hold_without_namespaces(tmp_path: Path) -> None:
    probe = solutions()["avoidance"]["hostile"]["avoidance.py"].replace('tried("fill", fill)', "")
    more = solutions()["waypoints"]["hostile"]["unit3_hw.py"].partition("data = []")[0]
    program = Program(
        {"a.py": f"{probe}\n{more}".encode()},
        "a.py",
        function=True,
        program=(sys.executable, "-s", "-c", _WITHOUT_NAMESPACES),
    )
    try:
        assert program.receive() == {"loaded": True}
        assert program.printed.count("refused") == 12
        assert "DONE" not in program.printed
    finally:
        program.close()


def test_a_machine_that_cannot_confine_refuses_to_grade() -> None:
    without = _WITHOUT_NAMESPACES.replace(
        "student.separate = lambda work, size: False",
        "sandbox._LIBC.syscall = lambda *a: -1; student.separate = lambda work, size: False",
    )
    with pytest.raises(ProtectionError, match="cannot be confined here: the kernel has no Landloc"):
        Program({"a.py": b""}, "a.py", program=(sys.executable, "-s", "-c", without))


def test_who_reads_nothing_does_not_hold_the_grader_up() -> None:
    code = b"import threading\nthreading.Event().wait()\n"
    program = Program({"a.py": code}, "a.py", function=True, patience=0.5)
    try:
        with pytest.raises(LostError, match="never comes"):
            program.send({"more": "x" * 200_000})
    finally:
        program.close()


def test_who_waits_for_ever_is_ended_though_no_cpu_time_passes() -> None:
    code = b"import threading\nthreading.Event().wait()\n"
    program = Program({"a.py": code}, "a.py", function=True, patience=0.5)
    try:
        with pytest.raises(LostError, match="waits for something that never comes"):
            program.receive()
    finally:
        program.close()


def test_what_is_handed_out_has_no_solution_and_can_be_graded(tmp_path: Path) -> None:
    for name in exercises():
        exercise = load_exercise(name)
        folder = tmp_path / name
        written = hand_out(exercise, folder)
        assert folder / "README.md" in written
        for one in exercise.criteria:
            assert one.about in (folder / "README.md").read_text()
        if exercise.skeleton:
            (folder / exercise.submit[0]).write_text("mine")
            assert hand_out(exercise, folder) == [folder / "README.md"]
            assert (folder / exercise.submit[0]).read_text() == "mine"


@pytest.mark.parametrize("name", ["kinematics", "estop", "amcl"])
def test_a_skeleton_gets_few_points(name: str, tmp_path: Path) -> None:
    exercise = load_exercise(name)
    hand_out(exercise, tmp_path)
    assert grade(exercise, tmp_path).points <= 0.4 * exercise.points


def test_what_leads_elsewhere_or_is_missing_has_no_points(tmp_path: Path) -> None:
    exercise = load_exercise("square")
    found = grade(exercise, tmp_path)
    assert (found.points, "has no square.py" in found.ended) == (0.0, True)
    (tmp_path / "square.py").symlink_to("/etc/passwd")
    with pytest.raises(SubmissionError, match=r"square\.py leads to another folder"):
        files_of(exercise, tmp_path)


def test_errors_of_an_exercise_name_what_is_valid(tmp_path: Path) -> None:
    with pytest.raises(ArjunaError, match="no homework 'squar'; did you mean 'square'"):
        load_exercise("squar")
    path = tmp_path / "mine.yaml"
    path.write_text("titel: x\nsubmit: a.py\ntask: t\ncriteria: {a: {points: 1, about: b}}\n")
    with pytest.raises(ArjunaError, match=r"'titel': did you mean 'title'.*'title' is missing"):
        load_exercise(str(path))
    path.write_text("title: x\nsubmit: a.py\ntask: t\ncriteria: {a: {points: 0, about: b}}\n")
    with pytest.raises(ArjunaError, match=r"criterion 'a' is none; valid: \{points: 2"):
        load_exercise(str(path))
    path.write_text(f"{path.read_text().replace('points: 0', 'points: 1')}duration: long\n")
    with pytest.raises(ArjunaError, match=r"'duration' is 'long'; valid: float"):
        load_exercise(str(path))


def test_a_mark_falls_from_good_to_bad() -> None:
    assert Mark.of(0.05, 0.1, 0.3, "") == (1.0, "")
    assert Mark.of(0.2, 0.1, 0.3, "{} m")[1] == "0.20 m"
    assert Mark.of(0.2, 0.1, 0.3, "").share == pytest.approx(0.5)
    assert Mark.of(float("nan"), 0.1, 0.3, "").share == 0.0
    assert Mark.of(-5.0, -5.0, -1.0, "").share == 1.0


def test_an_exercise_is_added_by_the_page_alone(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "homework.md").read_text(encoding="utf-8")
    for suffix, language in ((".yaml", "yaml"), (".py", "python")):
        code = re.search(rf"```{language}\n(.+?)```", page, re.DOTALL)
        assert code is not None
        (tmp_path / f"there{suffix}").write_text(code[1])
    exercise, folder = load_exercise(str(tmp_path / "there.yaml")), tmp_path / "in"
    hand_out(exercise, folder)
    nothing = grade(exercise, folder)
    assert nothing.points == 0.0
    assert nothing.marks["reaches"].why == "it ended 2.00 m from the goal"
    program = "from arjuna import Robot\n\nwith Robot() as robot:\n    robot.forward(2.0)\n"
    (folder / "there.py").write_text(program)
    assert grade(exercise, folder).points == 4.0
