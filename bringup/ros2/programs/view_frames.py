"""`ros2 run tf2_tools view_frames`: the tree of frames as a graph file and a PDF."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import yaml
from tf2_ros import Buffer, TransformListener

from bringup.ros2.client import Client
from bringup.ros2.discovery import SILENT
from bringup.ros2.errors import Ros2Error

Frames = dict[str, dict[str, Any]]
"""What tf2 says of each frame by its name: parent, broadcaster, rate and times."""


def main(words: list[str]) -> None:
    """Listen to /tf for a while, then write `frames_DATE.gv` and `frames_DATE.pdf`."""
    parser = argparse.ArgumentParser(
        prog="ros2 run tf2_tools view_frames", description=main.__doc__
    )
    parser.add_argument("-t", "--wait-time", type=float, default=5.0, help="how long to listen [s]")
    parser.add_argument("-o", "--output", help="name of the files, without ending")
    arguments = parser.parse_args(words)
    with Client(arguments, "view_frames") as client:
        log = client.node.get_logger()
        log.info(f"Listening to tf data for {arguments.wait_time} seconds...")
        buffer = Buffer(node=client.node)
        TransformListener(buffer, client.node)
        client.pause(arguments.wait_time)
        client.run_until(lambda: bool(_frames(buffer)), SILENT, required=False)
        name = arguments.output or time.strftime("frames_%Y-%m-%d_%H.%M.%S")
        log.info(f"Exporting graph in {name}.pdf file...")
    frames = _frames(buffer)
    if not frames:
        raise Ros2Error("no tf data received; is anything published on /tf or /tf_static?")
    Path(f"{name}.gv").write_text(dot(frames), encoding="utf-8")
    draw(frames, Path(f"{name}.pdf"))


def _frames(buffer: Buffer) -> Frames:
    found: Frames = yaml.safe_load(buffer.all_frames_as_yaml()) or {}
    return found


def label(frame: dict[str, Any]) -> list[str]:
    """Return what is said of the edge from a frame's parent."""
    return [
        f"Broadcaster: {frame['broadcaster']}",
        f"Average rate: {frame['rate']}",
        f"Buffer length: {frame['buffer_length']}",
        f"Most recent transform: {frame['most_recent_transform']}",
        f"Oldest transform: {frame['oldest_transform']}",
    ]


def dot(frames: Frames) -> str:
    """Return the tree in Graphviz's language."""
    rows = []
    for child, frame in sorted(frames.items()):
        text = "\\n".join([*label(frame), ""])
        rows.append(f'"{frame["parent"]}" -> "{child}"[label=" {text}"];')
    return "\n".join(["digraph G {", *rows, "}", ""])


def draw(frames: Frames, path: Path) -> None:
    """Draw the tree into a PDF."""
    from bringup.viewing.frame_tree import Frame, draw_tree

    tree = {child: Frame(child, (str(frame["parent"]),)) for child, frame in frames.items()}
    draw_tree(path, tree, {name: "\n".join(label(each)[1:3]) for name, each in frames.items()})
