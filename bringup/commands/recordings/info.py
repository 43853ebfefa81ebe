"""`info`: what a recording holds and lacks, and its repair."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("info out/bag",)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="an mcap, .db3 or .bag file, or a folder"
    )
    parser.add_argument(
        "--check", action="store_true", help="read every message, not only the index"
    )
    parser.add_argument(
        "--repair",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="FOLDER",
        help="write all that can be read into a new recording, with index (FILE_repaired)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print what there is; return 1 where something is missing and was not repaired."""
    from arjuna_core.bags.reader import Bag
    from arjuna_core.bags.writer import repair
    from bringup.recording import summary
    from bringup.terminal import show

    bag = Bag(arguments.file)
    if arguments.check:
        for _ in bag.messages():
            pass
    for line in summary.lines(bag):
        show(line)
    for line in summary.missing(bag):
        show(f"{'Missing:':19}{line}")
    if arguments.repair is not None:
        usual = arguments.file.with_name(f"{arguments.file.stem}_repaired")
        folder = arguments.repair if arguments.repair.name else usual
        show(f"{'Repaired:':19}{repair(bag, folder)} messages in {folder}")
        return 0
    return 1 if bag.problems else 0
