"""`ros2 run tf2_tools view_frames`: the tree of frames as a graph file and a PDF."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import yaml
from tf2_ros import Buffer, TransformListener

from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error

Frames = dict[str, dict[str, Any]]
"""What tf2 says of each frame by its name: parent, broadcaster, rate and times."""


def main(words: list[str]) -> int:
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
        client.spin(lambda: False, arguments.wait_time)
        name = arguments.output or time.strftime("frames_%Y-%m-%d_%H.%M.%S")
        log.info(f"Exporting graph in {name}.pdf file...")
    frames: Frames = yaml.safe_load(buffer.all_frames_as_yaml())
    if not frames:
        raise Ros2Error("no tf data received; is anything published on /tf or /tf_static?")
    Path(f"{name}.gv").write_text(dot(frames), encoding="utf-8")
    draw(frames, Path(f"{name}.pdf"))
    return 0


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


def layout(frames: Frames) -> dict[str, tuple[float, float]]:
    """Return where each frame is drawn: leaves side by side, each parent above its children."""
    parents = {child: str(frame["parent"]) for child, frame in frames.items()}
    roots = sorted(set(parents.values()) - parents.keys())
    places: dict[str, tuple[float, float]] = {}
    leaves = iter(range(len(parents) + len(roots)))

    def place(frame: str, depth: int) -> float:
        children = sorted(child for child in parents if parents[child] == frame)
        columns = [place(child, depth + 1) for child in children]
        column = sum(columns) / len(columns) if columns else float(next(leaves))
        places[frame] = (column, -float(depth))
        return column

    for root in roots:
        place(root, 0)
    return places


def draw(frames: Frames, path: Path) -> None:
    """Draw the tree into a PDF."""
    from matplotlib.figure import Figure

    places = layout(frames)
    columns = 1 + max(column for column, _ in places.values())
    rows = 1 - min(row for _, row in places.values())
    figure = Figure(figsize=(max(2.6 * columns, 5.0), max(1.6 * rows, 3.0)))
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.set_xlim(-0.6, columns - 0.4)
    axes.set_ylim(-rows + 0.6, 0.4)
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "black"}
    for child, edge in frames.items():
        (x0, y0), (x1, y1) = places[edge["parent"]], places[child]
        axes.plot((x0, x1), (y0, y1), color="0.6", zorder=0)
        text = "\n".join(label(edge)[1:3])
        axes.text((x0 + x1) / 2, (y0 + y1) / 2, text, fontsize=6, ha="center", va="center")
    for frame, (x, y) in places.items():
        axes.text(x, y, frame, ha="center", va="center", bbox=box, fontsize=8)
    figure.savefig(path)
