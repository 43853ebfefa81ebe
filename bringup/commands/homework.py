"""`homework`: exercises to hand out: a task sheet, a skeleton and what belongs to it."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("homework", "homework square", "homework my_exercise.yaml --out handout")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="of an exercise, or its YAML file (lists them)"
    )
    options.add(parser, "--out", help="where all goes (a folder of the exercise's name)")


def run(arguments: argparse.Namespace) -> int:
    """List the exercises, or write what a student gets."""
    from bringup.homework.exercise import exercises, hand_out, load_exercise
    from bringup.terminal import show

    if arguments.name is None:
        for exercise in map(load_exercise, exercises()):
            show(f"  {exercise.name:14}{exercise.title} ({exercise.points:g} points)")
        return 0
    exercise = load_exercise(arguments.name)
    folder = arguments.out or Path(exercise.name)
    for path in hand_out(exercise, folder):
        show(f"wrote {path}")
    show(f"then: python -m bringup grade {folder}")
    return 0
