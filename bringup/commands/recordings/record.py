"""`record`: write what the robot says into a recording, byte for byte."""

from __future__ import annotations

import argparse
import re
from datetime import datetime
from pathlib import Path

from bringup.parameters import options
from bringup.recording import selection

EXAMPLES = ("record", "record -o out/bag --topics /scan /odom")

_UNITS = {
    "b": 1.0,
    "kb": 1e3,
    "mb": 1e6,
    "gb": 1e9,
    "kib": 2.0**10,
    "mib": 2.0**20,
    "gib": 2.0**30,
    "s": 1.0,
    "min": 60.0,
    "h": 3600.0,
}
_TIMES = ("s", "min", "h")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        *("-o", "--output"),
        type=Path,
        metavar="FOLDER",
        help="where the recording goes; it must not exist (rosbag2_ and the time)",
    )
    parser.add_argument(
        *("-a", "--all"), action="store_true", help="all topics, which is what it does by default"
    )
    selection.add_options(parser)
    parser.add_argument(
        "--include-hidden-topics", action="store_true", help="also those with a part named _..."
    )
    parser.add_argument(
        "--split",
        type=_split,
        default=(0, 0.0),
        metavar="SIZE|TIME",
        help="go on in a new file after this much, such as 500MB, 90s or 10min",
    )
    parser.add_argument("--next", action="store_true", help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace) -> int:
    """Record until stopped."""
    from arjuna_core.bags.writer import BagFolder, SplitLimits
    from bringup.recording.record import record
    from bringup.recording.recorder import RecordOptions
    from bringup.terminal import show

    folder = arguments.output or Path(f"{datetime.now().astimezone():rosbag2_%Y_%m_%d-%H_%M_%S}")
    if arguments.next:
        folder = next_free(folder)
    chosen = selection.selection_of(arguments, arguments.include_hidden_topics)
    bag = BagFolder(folder, SplitLimits(*arguments.split))
    record(bag, RecordOptions(lambda topic, _: chosen.takes(topic)), show)
    return 0


def next_free(folder: Path) -> Path:
    """Return the folder, or the first of FOLDER_2, FOLDER_3 ... that is not there yet."""
    number, free = 1, folder
    while free.exists():
        number += 1
        free = folder.with_name(f"{folder.name}_{number}")
    return free


def _split(text: str) -> tuple[int, float]:
    """Return size [bytes] and duration [s] of a file, one of them 0."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?) *([a-z]+)", text.lower())
    if match is None or match[2] not in _UNITS or float(match[1]) == 0.0:
        valid = f"valid: a number with one of {', '.join(_UNITS)}"
        raise argparse.ArgumentTypeError(f"{text!r} is no size or time; {valid}")
    amount = options.positive(match[1]) * _UNITS[match[2]]
    return (0, amount) if match[2] in _TIMES else (max(round(amount), 1), 0.0)
