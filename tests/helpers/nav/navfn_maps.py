"""Maps on which planners are timed: rooms, mazes, halls, and such that lead nowhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.inflation import Inflation
from arjuna_nav.planners.waves.potential import reachable, traversal_costs

RESOLUTION = 0.05
ROBOT_RADIUS = 0.28
_ROOM, _WALL, _DOOR = 160, 4, 24  # [cells]
Cell = tuple[int, int]


class Course(NamedTuple):
    """A map and what is asked on it.

    Attributes:
        start: `(row, column)`.
        goal: As `start`.
        astar: Whether by A*.
    """

    costmap: Costmap
    start: Cell
    goal: Cell
    astar: bool = False


def inflated(data: NDArray[np.uint8]) -> Costmap:
    """Return lethal and free cells as a costmap with inflation."""
    Inflation(0.6, 5.0, ROBOT_RADIUS, RESOLUTION).apply(data)
    return Costmap(GridFrame(RESOLUTION, data.shape[1], data.shape[0]), data)


def rooms(size: int, seed: int) -> Costmap:
    """Return a square map of walls with doors and of boxes; its corners are free."""
    rng = np.random.default_rng(seed)
    data = np.zeros((size, size), np.uint8)
    walls = range(100, size - 50, _ROOM)
    for at in walls:
        data[at : at + _WALL, :] = data[:, at : at + _WALL] = 254
    for at in walls:
        for room in range(0, size - 20, _ROOM):  # a door of 1.2 m into each room
            row, column = np.minimum(room + rng.integers(0, 60, 2), size - 40)
            data[row : row + _DOOR, at : at + _WALL] = 0
            data[at : at + _WALL, column : column + _DOOR] = 0
    for row, column in rng.integers(0, size - 20, (size * size // 6000, 2)):
        data[row : row + rng.integers(2, 16), column : column + rng.integers(2, 16)] = 254
    data[:60, :60] = data[-60:, -60:] = 0
    return inflated(data)


def maze(size: int, passage: int, wall: int, seed: int) -> NDArray[np.uint8]:
    """Return a maze without loops from corner to corner, lethal or free.

    Args:
        size: Its edge [cells].
        passage: How wide its passages are [cells].
        wall: How thick its walls are [cells].

    Source: a spanning tree drawn by a random depth-first search.
    """
    rng = np.random.default_rng(seed)
    pitch = passage + wall
    count = (size - wall) // pitch
    data = np.full((size, size), 254, np.uint8)
    seen, stack = np.zeros((count, count), np.bool_), [(0, 0)]
    while stack:
        row, column = stack[-1]
        if not seen[row, column]:
            seen[row, column] = True
            data[_box(row, row, pitch, wall), _box(column, column, pitch, wall)] = 0
        beside = [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
        open_ = [c for c in beside if min(c) >= 0 and max(c) < count and not seen[c]]
        if not open_:
            stack.pop()
            continue
        r, c = open_[rng.integers(len(open_))]
        data[_box(row, r, pitch, wall), _box(column, c, pitch, wall)] = 0
        stack.append((r, c))
    return data


def _box(a: int, b: int, pitch: int, wall: int) -> slice:
    return slice(min(a, b) * pitch + wall, (max(a, b) + 1) * pitch)


def _no_path(size: int) -> Course:
    """Return rooms with a wall from side to side near their middle."""
    costmap = rooms(size, 0)
    costmap.data[size // 2 : size // 2 + _WALL] = 254
    return Course(inflated(costmap.data), (10, 10), (size - 11, size - 11))


def _tight_maze(size: int) -> Course:
    data = maze(size, 4, 1, 0)
    count = (size - 1) // 5
    end = (count - 1) * 5 + 2
    return Course(Costmap(GridFrame(RESOLUTION, size, size), data), (2, 2), (end, end))


def _wide_maze(size: int) -> Course:
    costmap, count = inflated(maze(size, 24, 2, 0)), (size - 2) // 26
    end = (count - 1) * 26 + 14
    return Course(costmap, (14, 14), (end, end))


def _far(size: int) -> Course:
    """Return the path from a corner to the cell nearest to the other one that can be reached."""
    costmap = rooms(size, 0)
    open_ = reachable(costmap.data, traversal_costs(), np.array([[10.0, 10.0, 0.0]]))
    cells = np.argwhere(open_[: size - 10, : size - 10])
    row, column = cells[np.argmax(cells.sum(axis=1))]
    return Course(costmap, (10, 10), (int(row), int(column)))


def _near(size: int) -> Course:
    """Return a goal 5 m off in the middle of rooms, with a wall or a box between."""
    costmap = rooms(size, 0)
    corner = size // 2 - 200
    free = corner + np.argwhere(costmap.data[corner : corner + 400, corner : corner + 400] == 0)
    start = free[len(free) // 2]
    for goal in free[np.abs(np.hypot(*(free - start).T) - 5.0 / RESOLUTION) < 1.0]:
        line = np.linspace(start, goal, 200).astype(int)
        if (costmap.data[tuple(line.T)] == 254).any():
            break
    return Course(costmap, (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1])))


def _empty(size: int) -> Course:
    data = np.zeros((size, size), np.uint8)
    costmap = Costmap(GridFrame(RESOLUTION, size, size), data)
    return Course(costmap, (10, 10), (size - 11, size - 11), astar=True)


COURSES: dict[str, Callable[[], Course]] = {
    "rooms 500, far": lambda: _far(500),
    "rooms 2000, far": lambda: _far(2000),
    "rooms 4000, far": lambda: _far(4000),
    "rooms 2000, 5 m": lambda: _near(2000),
    "rooms 4000, 5 m": lambda: _near(4000),
    "empty 1000, A*": lambda: _empty(1000),
    "maze 500, 1.2 m": lambda: _wide_maze(500),
    "maze 2000, 0.2 m": lambda: _tight_maze(2000),
    "no way, 2000": lambda: _no_path(2000),
}
"""The nine maps of `bench planner`."""
