"""`replay`: see a recording: in rerun's viewer, as its file, or as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path

from bringup.parameters import options

EXAMPLES = ("replay out/bag", "replay out/bag --picture drive.png --at 12")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="an mcap, .db3 or .bag file, or a folder"
    )
    parser.add_argument(
        "--save", type=Path, metavar="FILE.rrd", help="write a file of rerun's instead"
    )
    parser.add_argument("--web", action="store_true", help="show it in a browser")
    parser.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="write one picture instead; see --at"
    )
    parser.add_argument(
        "--at",
        type=options.finite,
        metavar="S",
        help="the picture's moment, from the recording's beginning [s] (its end)",
    )
    options.add(parser, "--package-path", help=options.MESHES)


def run(arguments: argparse.Namespace) -> int:
    """Show the recording until the viewer is closed, or write what was asked for."""
    from arjuna_core.bags.reader import Bag
    from bringup.terminal import show

    bag = Bag(arguments.file)
    if arguments.picture is not None:
        from bringup.viewing.pictures import draw_snapshot
        from bringup.viewing.snapshot import snapshot_of

        draw_snapshot(arguments.picture, snapshot_of(bag, arguments.at))
        show(f"{arguments.picture} shows the recording")
    if arguments.save is not None or arguments.picture is None:
        from bringup.viewing.rerun.show import replay

        options.extend_search(arguments)
        replay(bag, arguments.save, arguments.web, show)
    return 0
