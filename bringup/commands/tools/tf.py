"""`tf`: the tree of frames, as text and picture."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from bringup.parameters import options

if TYPE_CHECKING:
    from bringup.viewing.frame_tree import Frames

EXAMPLES = ("tf", "tf --picture frames.png")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "--picture", type=Path, metavar="FILE", help="draw it too, as .png, .pdf or .svg"
    )
    options.add(parser, "--duration", default=2.0)


def run(arguments: argparse.Namespace, patience: float = 5.0) -> int:
    """Show the tree; return 1 where no frame came within a time [s]."""
    from contextlib import closing

    from bringup.client.frames import FrameListener
    from bringup.client.session import Connection
    from bringup.terminal import show
    from bringup.viewing.frame_tree import tree_text

    with closing(Connection("arjuna_tf", arguments.namespace)) as session:
        listener = FrameListener(session)
        session.run_until(lambda: listener.found, patience, required=False)
        session.pause(arguments.duration)
        frames = listener.frames(None)
    if not frames:
        show("no frame on /tf or /tf_static; doctor says why")
        return 1
    show(tree_text(frames))
    if arguments.picture is not None:
        _draw(arguments.picture, frames)
    return 0


def _draw(path: Path, frames: Frames) -> None:
    """Write the picture."""
    from arjuna_core.errors import InputFileError
    from bringup.viewing.frame_tree import draw_tree

    try:
        draw_tree(path, frames, {name: frame.facts for name, frame in frames.items()})
    except (OSError, ValueError) as error:
        raise InputFileError(path, f"cannot be written: {error}") from error
