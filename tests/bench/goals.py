"""Random goals on a map, driven in lock-step, judged by the truth: the command `goals`."""

from __future__ import annotations

import argparse

from bringup.commands.goals import add_options
from bringup.scenarios.goals import drive_to_goals as run

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    add_options(parser)
    parser.add_argument(
        "--furnished", dest="scene", action="store_const", const="furnished", help="that scene"
    )
