"""`play`: publish a recording again."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options
from bringup.recording import selection

EXAMPLES = ("play out/bag", "play out/bag --rate 2 --clock")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="an mcap or .db3 file, or a folder")
    parser.add_argument(
        *("-r", "--rate"),
        type=options.positive,
        default=1.0,
        metavar="FACTOR",
        help="recorded seconds a second (1)",
    )
    parser.add_argument("-l", "--loop", action="store_true", help="begin again at the end")
    parser.add_argument(
        "--start-offset",
        type=options.finite,
        default=0.0,
        metavar="S",
        help="where in the recording to begin [s] (0)",
    )
    paused = "begin with a pause; space resumes"
    parser.add_argument("-p", "--start-paused", action="store_true", help=paused)
    parser.add_argument(
        "--clock",
        type=options.positive,
        nargs="?",
        const=40.0,
        default=0.0,
        metavar="HZ",
        help="publish the recorded time on /clock, where the recording has no /clock (40 Hz)",
    )
    parser.add_argument(
        *("-d", "--delay"),
        type=options.factor,
        default=1.0,
        metavar="S",
        help="wait first, so that those who listen find the player [s] (1)",
    )
    parser.add_argument(
        *("-m", "--remap"),
        type=_remap,
        nargs="+",
        default=[],
        metavar="OLD:=NEW",
        help="publish a topic under another name",
    )
    selection.add_options(parser)


def run(arguments: argparse.Namespace) -> int:
    """Play until the end, or until stopped."""
    from arjuna_core.bags.reader import Bag
    from bringup.recording.play import play
    from bringup.recording.playback import PlayOptions
    from bringup.terminal import show

    chosen = PlayOptions(
        takes=selection.selection_of(arguments).takes,
        rate=arguments.rate,
        offset=max(arguments.start_offset, 0.0),
        loop=arguments.loop,
        paused=arguments.start_paused,
        clock_hz=arguments.clock,
        settling=arguments.delay,
        remap=dict(arguments.remap),
    )
    play([Bag(arguments.file)], chosen, show)
    return 0


def _remap(text: str) -> tuple[str, str]:
    old, found, new = text.partition(":=")
    if not (found and old.strip("/") and new.strip("/")):
        raise argparse.ArgumentTypeError(f"{text!r} is no new name; valid: /old:=/new")
    return f"/{old.strip('/')}", f"/{new.strip('/')}"
