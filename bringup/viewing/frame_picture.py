"""A picture of the tree of frames."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

_WIDE, _HIGH = 2.6, 1.4  # [inch] for each leaf and each generation


def layout(parents: Mapping[str, str]) -> dict[str, tuple[float, float]]:
    """Return where each frame is drawn: leaves side by side, each parent above its children.

    Args:
        parents: The parent of each frame; those that are in a loop are left out.
    """
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


def draw_tree(path: Path, parents: Mapping[str, str], labels: Mapping[str, str]) -> None:
    """Write a picture of a tree.

    Args:
        path: The file; its ending says the format.
        parents: The parent of each frame.
        labels: What to write on the edge from each frame's parent.
    """
    places = layout(parents)
    columns = 1 + max((column for column, _ in places.values()), default=0.0)
    rows = 1 - min((row for _, row in places.values()), default=0.0)
    figure = Figure(figsize=(max(_WIDE * columns, 5.0), max(_HIGH * rows, 3.0)))
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.set_xlim(-0.6, columns - 0.4)
    axes.set_ylim(-rows + 0.6, 0.4)
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "black"}
    edge = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "pad": 0.1}
    for child, (x1, y1) in places.items():
        if child in parents:
            x0, y0 = places[parents[child]]
            axes.plot((x0, x1), (y0, y1), color="0.6", zorder=0)
            middle = ((x0 + x1) / 2, (y0 + y1) / 2)
            axes.text(*middle, labels[child], fontsize=6, ha="center", va="center", bbox=edge)
    for frame, (x, y) in places.items():
        axes.text(x, y, frame, ha="center", va="center", bbox=box, fontsize=8)
    figure.savefig(path, dpi=110)
