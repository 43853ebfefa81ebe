"""The tree of frames as plain values, as text and as a picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Frame:
    """A frame of /tf or /tf_static.

    Attributes:
        parents: Every parent it was given, the last one last.
        static: Whether its last transform came on /tf_static.
        rate: Transforms a second, of the listener's time [Hz].
        age: How far its newest stamp lies behind the robot's clock [s]; negative is ahead of it.
        variants: How many different transforms came on /tf_static.
    """

    name: str
    parents: tuple[str, ...]
    static: bool = False
    rate: float = 0.0
    age: float = 0.0
    variants: int = 0

    @property
    def parent(self) -> str:
        """The parent it was given last."""
        return self.parents[-1]

    @property
    def of_another_clock(self) -> bool:
        """True if its stamps and the robot's clock are days apart, as system and simulated time."""
        return abs(self.age) > 1e6  # [s]

    @property
    def facts(self) -> str:
        """Its rate and age, in a few words."""
        if self.static:
            return "static" if self.variants < 2 else f"static, {self.variants} different ones"
        if self.of_another_clock:
            return f"{self.rate:.1f} Hz, stamped by another clock"
        moment = f"{self.age:.2f} s old" if self.age >= 0.0 else f"{-self.age:.2f} s ahead"
        return f"{self.rate:.1f} Hz, {moment}"


Frames = Mapping[str, Frame]


def roots(frames: Frames) -> list[str]:
    """Return the frames without a parent, one a tree, in order."""
    return sorted({frame.parent for frame in frames.values()} - set(frames))


def children(frames: Frames, name: str) -> list[str]:
    """Return a frame's children in order."""
    return sorted(child for child, frame in frames.items() if frame.parent == name)


def loops(frames: Frames) -> list[str]:
    """Return the frames that no tree reaches: they are their own ancestors."""
    return sorted(name for name in frames if chain(frames, name)[-1] in frames)


def chain(frames: Frames, name: str) -> list[str]:
    """Return a frame and its ancestors, up to where they end or come again."""
    found = [name]
    while found[-1] in frames and frames[found[-1]].parent not in found:
        found.append(frames[found[-1]].parent)
    return found


def tree_text(frames: Frames) -> str:
    """Return the trees as text, a frame a line."""
    lines = []
    for root in roots(frames):
        lines += [root, *_below(frames, root, "")]
    lines += [f"{name} (in a loop through {frames[name].parent})" for name in loops(frames)]
    return "\n".join(lines)


def _below(frames: Frames, name: str, indent: str) -> Iterator[str]:
    below = children(frames, name)
    for child in below:
        last = child == below[-1]
        label = f"{indent}{'└─ ' if last else '├─ '}{child}"
        frame = frames[child]
        twins = f"  also under {', '.join(frame.parents[:-1])}" if frame.parents[1:] else ""
        yield f"{label:<39} {frame.facts}{twins}"
        yield from _below(frames, child, indent + ("   " if last else "│  "))


def layout(frames: Frames) -> dict[str, tuple[float, float]]:
    """Return the columns and rows of frames in a picture, each parent above its children.

    Leaves are side by side; frames in a loop are left out.
    """
    found: dict[str, tuple[float, float]] = {}
    leaves = itertools.count()

    def locate(frame: str, depth: int) -> float:
        columns = [locate(child, depth + 1) for child in children(frames, frame)]
        column = sum(columns) / len(columns) if columns else float(next(leaves))
        found[frame] = (column, -float(depth))
        return column

    for root in roots(frames):
        locate(root, 0)
    return found


def draw_tree(path: Path, frames: Frames, labels: Mapping[str, str]) -> None:
    """Write a picture of a tree.

    Args:
        path: The file; its ending says the format.
        labels: What to write on the edge from each frame's parent.
    """
    from matplotlib.figure import Figure

    at = layout(frames)
    columns = 1 + max((column for column, _ in at.values()), default=0.0)
    rows = 1 - min((row for _, row in at.values()), default=0.0)
    figure = Figure(figsize=(max(2.6 * columns, 5.0), max(1.4 * rows, 3.0)))  # [inch]
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.set_xlim(-0.6, columns - 0.4)
    axes.set_ylim(-rows + 0.6, 0.4)
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "black"}
    edge = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "pad": 0.1}
    for child, (x1, y1) in at.items():
        if child in frames:
            x0, y0 = at[frames[child].parent]
            axes.plot((x0, x1), (y0, y1), color="0.6", zorder=0)
            middle = ((x0 + x1) / 2, (y0 + y1) / 2)
            axes.text(*middle, labels[child], fontsize=6, ha="center", va="center", bbox=edge)
    for frame, (x, y) in at.items():
        axes.text(x, y, frame, ha="center", va="center", bbox=box, fontsize=8)
    figure.savefig(path, dpi=110)
