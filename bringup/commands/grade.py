"""`grade`: the points of a submission, or of a whole class, by the simulator's truth."""

from __future__ import annotations

import argparse
import hashlib
import resource
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.homework.exercise import Exercise

EXAMPLES = (
    "grade square/",
    "grade my_square.py --exercise square",
    "grade --exercise square --students handed_in --out grades/square",
)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "submission", nargs="?", type=Path, metavar="FILE|FOLDER", help="what is handed in"
    )
    parser.add_argument(
        "--exercise", metavar="NAME|FILE",
        help="the homework's name or YAML file (the one whose file is handed in)",
    )  # fmt: skip
    parser.add_argument(
        "--students", type=Path, metavar="DIR", help="a folder with a folder of each student"
    )
    options.add(parser, "--out", help="where pages go (out/grades/ and the exercise's name)")
    options.add(parser, "--jobs")
    parser.add_argument("--submission", type=Path, dest="one", help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace) -> int:
    """Grade; return 0 where all could be graded, whatever their points."""
    from arjuna_core.errors import ArjunaError

    submission = arguments.one or arguments.submission
    if (submission is None) == (arguments.students is None) or arguments.jobs < 1:
        raise ArjunaError("say what to grade: FILE|FOLDER, or --students DIR; --help has both")
    if submission is not None:
        return _grade(arguments, submission)
    folders = _folders(arguments.students)
    if not folders:
        raise ArjunaError(f"{arguments.students} holds no folder; valid: one of each student")
    exercise = _exercise(arguments, folders[0])
    return _grade_all(arguments, exercise, folders)


def _folders(students: Path) -> list[Path]:
    from arjuna_core.errors import InputFileError

    try:
        found = list(students.iterdir())
    except OSError as error:
        raise InputFileError(students, f"cannot be read: {error.strerror}") from error
    real = (path for path in found if path.is_dir() and not path.is_symlink())
    return sorted(path for path in real if not path.name.startswith("."))


def _exercise(arguments: argparse.Namespace, submission: Path) -> Exercise:
    """Return the exercise that is named, or the one whose file is handed in."""
    from arjuna_core.errors import ArjunaError
    from bringup.homework.exercise import exercises, load_exercise

    if arguments.exercise is not None:
        return load_exercise(arguments.exercise)
    names = {submission.name} if submission.is_file() else {p.name for p in submission.glob("*")}
    found = [one for one in map(load_exercise, exercises()) if one.submit[0] in names]
    if len(found) != 1:
        of = f"{submission} is a submission of {len(found) or 'no'} known homework"
        raise ArjunaError(f"{of}; say --exercise, one of: {', '.join(exercises())}")
    return found[0]


def _grade(arguments: argparse.Namespace, submission: Path) -> int:
    from rclpy.logging import LoggingSeverity, set_logger_level

    from arjuna_core.errors import InputFileError
    from bringup.homework.grading import grade
    from bringup.homework.report import text_of, write_grade
    from bringup.terminal import show

    exercise = _exercise(arguments, submission)
    if arguments.one is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (600, 600))  # [s] that its parameters may cost
    elif not submission.exists():
        raise InputFileError(submission, "is not there; valid: a file or folder to grade")
    set_logger_level("", LoggingSeverity.FATAL)
    found = grade(exercise, submission)
    write_grade(arguments.out or Path("out/grades") / exercise.name, found)
    show(text_of(found))
    return 0


def _grade_all(arguments: argparse.Namespace, exercise: Exercise, folders: list[Path]) -> int:
    """Grade a class's submissions, those that have changed since the last time or have no grade."""
    from bringup.campaign.plan import FOLDER, Campaign, Run
    from bringup.campaign.pool import LocalPool, Progress, forks_of
    from bringup.campaign.report import PAGE
    from bringup.campaign.runner import run_all
    from bringup.homework.report import RESULT, TABLE, write_class
    from bringup.stack import LOCALIZATION_GROUP, SIM_GROUP
    from bringup.terminal import show, stopped_by_signals

    out = (arguments.out or Path("out/grades") / exercise.name).resolve()
    command = ("grade", "--exercise", arguments.exercise or exercise.name, "--out", FOLDER)
    campaign = Campaign(exercise.name, command, RESULT, {}, {"graded": True}, timeout=1800.0)
    runs = [
        Run(path.name, {"student": path.name}, {"submission": str(path.resolve())})
        for path in folders
    ]
    for one, path in zip(runs, folders, strict=True):
        _forget_if_changed(out / one.name, _digest(exercise, path))
    forks = forks_of(arguments, (SIM_GROUP, LOCALIZATION_GROUP))
    pool = LocalPool(arguments.jobs, forks=forks)
    progress = Progress(len(runs), pool)
    outcomes = run_all(
        campaign, runs, out, pool, progress.ended, stopped_by_signals(), progress.lost,
        progress.show,
    )  # fmt: skip
    lost = {one.name: one.reason for one in outcomes if not one.success}
    write_class(out, exercise, [one.name for one in runs], lost)
    show(f"{len(outcomes) - len(lost)} of {len(runs)} graded; see {out / PAGE} and {out / TABLE}")
    return 0 if len(outcomes) == len(runs) and not lost else 1


def _digest(exercise: Exercise, submission: Path) -> str:
    """Return what a grade is of: the exercise's files and the submission's."""
    from arjuna_core.files.input_file import read_bytes
    from bringup.homework.exercise import SubmissionError, files_of

    found = hashlib.sha256()
    for path in (exercise.path, exercise.path.with_suffix(".py")):
        found.update(read_bytes(path))
    try:
        for name, data in files_of(exercise, submission).items():
            found.update(f"{name}\0{len(data)}\0".encode() + data)
    except SubmissionError as error:
        found.update(str(error).encode())
    return found.hexdigest()


def _forget_if_changed(folder: Path, digest: str) -> None:
    """Let a submission be graded again that is not what it was."""
    from arjuna_core.files.input_file import read_text
    from arjuna_core.files.whole_file import emptied_folder, write_atomically

    mark = folder / "submission.sha256"
    if not mark.exists() or read_text(mark) != digest:
        emptied_folder(folder, "*.json", "*.html", "*.png")
        write_atomically(mark, digest.encode())
