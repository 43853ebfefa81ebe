"""Grades as files: a page and figures of each submission, a page and a CSV table of a class."""

from __future__ import annotations

import csv
import html
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.report import PAGE, Table, page_of
from bringup.homework.exercise import Exercise
from bringup.homework.grading import Grade

RESULT, PICTURE, TABLE = "result.json", "path.png", "grades.csv"


def figures_of(grade: Grade) -> dict[str, Any]:
    """Return a grade as JSON has it."""
    marks = {
        name: {"points": grade.points_of(name), "why": mark.why}
        for name, mark in grade.marks.items()
    }
    return {
        "graded": True,
        "exercise": grade.exercise.name,
        "points": grade.points,
        "of": grade.exercise.points,
        "criteria": marks,
        "ended": grade.ended,
    }


def text_of(grade: Grade) -> str:
    """Return a grade as lines for the terminal."""
    lines = [f"{grade.exercise.title}: {grade.points:g} of {grade.exercise.points:g} points"]
    lines += [f"  {grade.ended}"] if grade.ended else []
    for one in grade.exercise.criteria:
        why = grade.marks[one.name].why
        lines.append(f"  {grade.points_of(one.name):4g} of {one.points:<4g} {one.about}")
        lines += [f"               {why}"] if why else []
    return "\n".join(lines)


def write_grade(folder: Path, grade: Grade) -> None:
    """Write a submission's page, its picture and its figures.

    Raises:
        OSError: One cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    exercise = grade.exercise
    rows = [
        [one.about, f"{grade.points_of(one.name):g}", f"{one.points:g}", grade.marks[one.name].why]
        for one in exercise.criteria
    ]
    rows.append(["all", f"{grade.points:g}", f"{exercise.points:g}", grade.ended])
    parts = [Table(["criterion", "points", "of", "what went wrong"], rows).html()]
    if grade.snapshot is not None:
        from bringup.viewing.pictures import draw_snapshot

        draw_snapshot(folder / PICTURE, grade.snapshot)
        parts.append(f'<img alt="the robot\'s path" src="{PICTURE}">')
    if grade.printed:
        parts.append(f"<h2>What it printed last</h2><pre>{html.escape(grade.printed)}</pre>")
    write_atomically(folder / PAGE, page_of(exercise.title, parts).encode())
    text = json.dumps(figures_of(grade), indent=2)
    write_atomically(folder / RESULT, f"{text}\n".encode())


def write_class(
    folder: Path, exercise: Exercise, students: Sequence[str], lost: Mapping[str, str]
) -> None:
    """Write the table of a class, as a page and as CSV, with why a submission is `lost`.

    Raises:
        OSError: One cannot be written.
    """
    names = [one.name for one in exercise.criteria]
    rows, links = [], []
    for student in students:
        result = _result(folder / student) or {"points": 0.0, "ended": lost.get(student, "")}
        marks = result.get("criteria", {})
        points = [f"{marks[name]['points']:g}" if name in marks else "0" for name in names]
        rows.append([student, f"{result['points']:g}", *points, _why(result)])
        links.append(f'<a href="{html.escape(student)}/">{html.escape(student)}</a>')
    head = ["student", "points", *names, "what went wrong"]
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([head, *map(_plain, rows)])
    write_atomically(folder / TABLE, out.getvalue().encode())
    body = Table(head, rows).html() + "<p>Pages: " + ", ".join(links) + "</p>"
    page = page_of(f"{exercise.title}: {len(rows)} students", [body])
    write_atomically(folder / PAGE, page.encode())


def _plain(cells: Iterable[str]) -> list[str]:
    """Return cells that no table program takes for a formula."""
    return [f"'{cell}" if cell[:1] in "=+-@\t" and cell[:1] else cell for cell in cells]


def _why(result: Mapping[str, Any]) -> str:
    whys = [mark["why"] for mark in result.get("criteria", {}).values() if mark["why"]]
    return "; ".join(dict.fromkeys([*([result["ended"]] if result["ended"] else []), *whys]))


def _result(folder: Path) -> dict[str, Any] | None:
    try:
        return dict(read_json(folder / RESULT))
    except (InputFileError, TypeError, ValueError):
        return None
