"""Pictures of a run: the map, and the map under the paths and goals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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


def _save(figure: Figure, path: Path | BinaryIO) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=110, metadata={"Software": "arjuna"})


def draw_map(path: Path, grid: OccupancyGrid) -> None:
    """Write a picture of a map."""
    figure = Figure(figsize=(7.0, 7.0))
    _draw_map(figure, grid, "Map")
    _save(figure, path)


def _broken_at_leaps(points: NDArray[np.float64], leap: float = 0.1) -> NDArray[np.float64]:
    """Put a gap where the robot was carried, so that no line is drawn there."""
    leaps = np.flatnonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) > leap) + 1
    return np.insert(points, leaps, np.nan, axis=0)


def draw_trajectory(
    path: Path,
    grid: OccupancyGrid,
    table: NDArray[np.float64],
    goals: Iterable[tuple[float, float, float, bool]],
    touches: Sequence[tuple[float, float]] = (),
) -> None:
    """Write a picture of a map with the true path, the estimated path and the goals.

    Args:
        table: Time, true and estimated x, y, yaw, `(N, 7) float64` [s, m, m, rad, m, m, rad].
        goals: x, y, yaw [m, m, rad] and whether it was reached.
        touches: Where the robot was when it touched something [m].
    """
    figure = Figure(figsize=(7.5, 7.5))
    axes = _draw_map(figure, grid, "The robot's path, true and estimated")
    axes.plot(*_broken_at_leaps(table[:, 1:3]).T, **_TRUE, label="true")
    axes.plot(*_broken_at_leaps(table[:, 4:6]).T, **_BELIEVED, label="estimated")
    for number, (x, y, yaw, reached) in enumerate(goals, 1):
        colour = "tab:orange" if reached else "tab:red"
        axes.plot(x, y, "o", color=colour, ms=9)
        axes.annotate(str(number), (x, y), ha="center", va="center", fontsize=7)
        axes.arrow(x, y, 0.3 * np.cos(yaw), 0.3 * np.sin(yaw), color=colour, width=0.02)
    _draw_touches(axes, touches)
    axes.legend(loc="upper right")
    _save(figure, path)


def _draw_touches(axes: Axes, touches: Sequence[tuple[float, float]]) -> None:
    if touches:
        axes.plot(*np.array(touches).T, "x", color="tab:red", ms=12, mew=3, label="touched")


def draw_path(path: Path, grid: OccupancyGrid, poses: NDArray[np.float64]) -> None:
    """Write a picture of a map with a path on it, poses `(N, 3) float64` in the map's frame."""
    figure = Figure(figsize=(9.0, 9.0))
    axes = _draw_map(figure, grid, "Map and trajectory")
    axes.plot(*poses[:, :2].T, color="tab:blue", lw=0.8, label="trajectory")
    axes.plot(*poses[0, :2], "o", color="tab:green", ms=7, label="start")
    axes.plot(*poses[-1, :2], "s", color="tab:red", ms=7, label="end")
    axes.legend(loc="upper right")
    _save(figure, path)


def draw_snapshot(
    path: Path | BinaryIO, snapshot: Snapshot, title: str = "", size: float = 9.0
) -> None:
    """Write a picture of a recording's moment, of a size [inch]."""
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
            axes.plot(*_broken_at_leaps(np.array(trail), 0.3).T, **style, label=label)
    if len(snapshot.scan):
        axes.plot(*snapshot.scan.T, ".", color="tab:red", ms=4, label="scan")
    _draw_touches(axes, [(pose.x, pose.y) for pose in snapshot.touches])
    for goal in snapshot.goals:
        _draw_pose(axes, goal, "tab:orange")
    if snapshot.robot is not None:
        _draw_pose(axes, snapshot.robot, "black")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right")
    _save(figure, path)


def _draw_pose(axes: Axes, pose: SE2, colour: str) -> None:
    forward = 0.35 * np.array([np.cos(pose.theta), np.sin(pose.theta)])
    axes.plot(pose.x, pose.y, "o", color=colour, ms=9)
    axes.arrow(pose.x, pose.y, *forward, color=colour, width=0.03)
