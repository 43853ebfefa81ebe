"""Unmapped boxes and people who walk about, put into a running simulator."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError
from arjuna_core.grid import OCCUPIED, GridFrame, OccupancyGrid
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import PERSON, Trajectory, person
from bringup.scenarios.space import FreeSpace, length_of

_EDGE, _HEIGHT = 0.5, 1.0  # of a box [m]
_APART = 1.5  # between boxes, and from the robot to them and to people, at first [m]


def boxes_in(
    grid: OccupancyGrid, count: int, start: SE2, rng: np.random.Generator, beside: float = 1.0
) -> NDArray[np.float64]:
    """Return the middles of boxes on a map, `(N, 2)` [m], each so far beside walls [m]."""
    space, found = FreeSpace(grid, _EDGE, beside), [(start.x, start.y)]
    while len(found) <= count:
        pose = space.draw(rng)
        if all(math.dist((pose.x, pose.y), other) > _APART for other in found):
            found.append((pose.x, pose.y))
    return np.array(found[1:]).reshape(-1, 2)


def with_boxes(grid: OccupancyGrid, boxes: NDArray[np.float64]) -> OccupancyGrid:
    """Return a map on which the boxes stand as well."""
    data, frame = grid.data.copy(), grid.frame
    half = math.ceil(0.5 * _EDGE / frame.resolution)
    for x, y in boxes.tolist():
        row, column = frame.to_cell(x, y)
        data[row - half : row + half + 1, column - half : column + half + 1] = OCCUPIED
    return OccupancyGrid(frame, data)


def route_past(
    points: Sequence[tuple[float, float]], boxes: Iterable[NDArray[np.float64]]
) -> list[tuple[float, float]]:
    """Return a path by points that leads a person round boxes; a point in one moves beside it [m].

    Args:
        boxes: Their corners from above in order, `(4, 2)` each [m].

    Raises:
        ArjunaError: Two points have no path between them.
    """
    edge, margin = 0.05, 3.0  # of a cell, and round the points [m]
    low = np.min(points, axis=0) - margin
    height, width = np.ceil((np.max(points, axis=0) + margin - low) / edge).astype(int)[::-1]
    frame = GridFrame(edge, int(width), int(height), SE2(*low.tolist()))
    data = np.zeros(frame.shape, np.int8)
    centres = frame.to_points(np.argwhere(data == 0))
    for box in boxes:
        sides = np.roll(box, -1, axis=0) - box
        x, y = (centres[:, None] - box).T
        left = sides[:, :1] * y - sides[:, 1:] * x >= 0.0  # of each side
        data.flat[left.all(axis=0)] = OCCUPIED
    if not data.any():
        return list(points)
    room = PERSON[0] + edge
    space = FreeSpace(OccupancyGrid(frame, data), room, room)
    stops = [space.nearest(*point) for point in points]
    route = [(stops[0].x, stops[0].y)]
    for start, goal in itertools.pairwise(stops):
        leg = space.shortest_path(goal, start)
        if leg is None:
            ends = f"from {start.x:g},{start.y:g} to {goal.x:g},{goal.y:g}"
            raise ArjunaError(f"no path {ends} is wide enough for a person")
        route += [*map(tuple, leg[1:-1].tolist()), (goal.x, goal.y)]
    return route


def settle(
    stage: Any,
    grid: OccupancyGrid,
    boxes: NDArray[np.float64],
    people: int,
    start: SE2,
    rng: np.random.Generator,
    walked: Mapping[str, float],
) -> None:
    """Put boxes, by their middles `(N, 2)` [m], and people into a simulator's stage.

    People walk to and fro on routes on the grid, away from the robot's start; `walked` says by name
    how far somebody is already [s].
    """
    half = Pose3((0.0, 0.0, 0.5 * _HEIGHT))
    box = (Part(Shape(Kind.BOX, (_EDGE, _EDGE, _HEIGHT)), half, (0.6, 0.5, 0.3, 1.0)),)
    for k, (x, y) in enumerate(boxes.tolist()):
        stage.spawn(Entity(f"box_{k}", box, start=Pose3((x, y, 0.0)), spawned=True))
    for k, walk in zip(range(people), _walks(grid, start, rng), strict=False):
        name = f"person_{k}"
        stage.spawn(Entity(name, person(), trajectory=walk, spawned=True), walked.get(name, 0.0))


def _walks(
    grid: OccupancyGrid,
    start: SE2,
    rng: np.random.Generator,
    shortest: float = 3.0,
    speeds: tuple[float, float] = (0.4, 1.2),
) -> Iterator[Trajectory]:
    """Yield walks to and fro along paths of a length [m] at least, at speeds between two [m/s]."""
    edge = grid.frame.resolution
    space = FreeSpace(grid, PERSON[0] + edge, PERSON[0] + 2.0 * edge)
    while True:
        route = space.shortest_path(space.draw(rng), space.draw(rng))
        if route is None or length_of(route) < shortest:
            continue
        if math.dist(route[0], (start.x, start.y)) < _APART:
            continue
        yield Trajectory.along(np.vstack((route, route[-2:0:-1])), float(rng.uniform(*speeds)))
