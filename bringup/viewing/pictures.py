"""A picture of a run: the map under the robot, its paths and its goals."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.viewing.snapshot import Snapshot

# A path that is believed rightly lies on the true one: that one is broad and pale below it.
_TRUE: dict[str, Any] = {"color": "#9be39b", "lw": 6.0}
_BELIEVED: dict[str, Any] = {"color": "tab:blue", "lw": 1.5}
_PLAN: dict[str, Any] = {"color": "tab:purple", "lw": 1.5}


def _draw_map(figure: Figure, grid: OccupancyGrid, title: str) -> Axes:
    shades = np.select([grid.occupied(), grid.free()], [0.0, 1.0], 0.8)
    frame = grid.frame
    right = frame.origin.x + frame.width * frame.resolution
    top = frame.origin.y + frame.height * frame.resolution
    axes = figure.add_subplot()
    axes.imshow(
        shades,
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
        origin="lower",
        extent=(frame.origin.x, right, frame.origin.y, top),
        interpolation="nearest",
    )
    axes.set(xlabel="x [m]", ylabel="y [m]", title=title, aspect="equal")
    return axes


def _broken_at_leaps(points: NDArray[np.float64], leap: float) -> NDArray[np.float64]:
    """Put a gap where points are so far apart [m], so that no line is drawn there."""
    leaps = np.flatnonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) > leap) + 1
    return np.insert(points, leaps, np.nan, axis=0)


def draw_snapshot(
    path: Path | BinaryIO,
    snapshot: Snapshot,
    title: str = "",
    size: float = 9.0,
    leap: float = 0.3,
) -> None:
    """Write a picture of a moment, of a size [inch]; the goals are numbered in their order.

    A path has a gap where it leaps so far [m], as where a robot is carried.
    """
    figure = Figure(figsize=(size, size))
    title = title or f"The robot after {snapshot.time:.1f} s"
    if snapshot.grid is not None:
        axes = _draw_map(figure, snapshot.grid, title)
    else:
        axes = figure.add_subplot()
        axes.set(xlabel="x [m]", ylabel="y [m]", title=title)
        axes.set_aspect("equal", "datalim")
    for trail, style, label in (
        (snapshot.true, _TRUE, "true"),
        (snapshot.believed, _BELIEVED, "believed"),
        (snapshot.plan, _PLAN, "plan"),
    ):
        if len(trail):
            axes.plot(*_broken_at_leaps(np.array(trail), leap).T, **style, label=label)
    if driven := snapshot.true or snapshot.believed:
        axes.plot(*driven[0], "o", color="tab:green", ms=7, label="start")
    if len(snapshot.scan):
        axes.plot(*snapshot.scan.T, ".", color="tab:red", ms=4, label="scan")
    if snapshot.touches:
        touches = [(pose.x, pose.y) for pose in snapshot.touches]
        axes.plot(*np.array(touches).T, "x", color="tab:red", ms=12, mew=3, label="touched")
    for number, goal in enumerate(snapshot.goals, 1):
        _draw_pose(axes, goal, "tab:red" if number in snapshot.missed else "tab:orange")
        axes.annotate(str(number), (goal.x, goal.y), ha="center", va="center", fontsize=7)
    if snapshot.robot is not None:
        _draw_pose(axes, snapshot.robot, "black")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right")
    figure.tight_layout()
    figure.savefig(path, dpi=110, metadata={"Software": "arjuna"})


def _draw_pose(axes: Axes, pose: SE2, colour: str) -> None:
    forward = 0.35 * np.array([np.cos(pose.theta), np.sin(pose.theta)])
    axes.plot(pose.x, pose.y, "o", color=colour, ms=9)
    axes.arrow(pose.x, pose.y, *forward, color=colour, width=0.03)
