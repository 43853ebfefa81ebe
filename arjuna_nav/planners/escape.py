"""Escape paths for a robot that stands too near to an obstacle."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from arjuna_core.arrays import Bytes, Floats, Singles
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.costmap import LETHAL, Costmap
from arjuna_nav.costmap.footprint import Footprint

_NEIGHBOURS = tuple((r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if (r, c) != (0, 0))


class Escape:
    """Paths through the cells within an obstacle's inscribed radius to those where a robot may be.

    A bump, an error of its pose or a moving obstacle brings a robot there; it is led
    out by the nearest path, and where that does not lead to its goal, by another. No path crosses a
    lethal cell but the one it starts on.

    Args:
        data: `(height, width) uint8` costs of a costmap.
        costs: Of `traversal_costs`.
        start: `(row, column)` of the robot.
        radius: How far to look [cells].

    Attributes:
        exits: `(N, 2) int64` row and column of the cells where a robot may be, the nearest first.
        distances: `(N,) float64` how far each is [cells].
    """

    def __init__(self, data: Bytes, costs: Singles, start: tuple[int, int], radius: float) -> None:
        self._before: dict[tuple[int, int], tuple[int, int]] = {start: start}
        exits: list[tuple[int, int]] = []
        distances: list[float] = []
        best = {start: 0.0}
        queue = [(0.0, start)]
        while queue:
            distance, cell = heapq.heappop(queue)
            if distance > best[cell]:
                continue
            if costs[data[cell]] < math.inf:
                exits.append(cell)
                distances.append(distance)
                continue
            for d_r, d_c in _NEIGHBOURS:
                other, far = (cell[0] + d_r, cell[1] + d_c), distance + math.hypot(d_r, d_c)
                inside = 0 <= other[0] < data.shape[0] and 0 <= other[1] < data.shape[1]
                if not inside or data[other] == LETHAL or far > radius:
                    continue
                if far < best.get(other, math.inf):
                    best[other], self._before[other] = far, cell
                    heapq.heappush(queue, (far, other))
        self.exits = np.array(exits, dtype=np.int64).reshape(-1, 2)
        self.distances = np.array(distances, dtype=np.float64)

    @property
    def nearest(self) -> tuple[int, int]:
        """The nearest exit."""
        return int(self.exits[0, 0]), int(self.exits[0, 1])

    def seeds(self, cost: float) -> Floats:
        """Return where a search begins, `(N, 3)`: row, column and the cost to come there."""
        # 20 times a free cell's cost where the robot may not be: the nearest exit wins.
        return np.column_stack((self.exits.astype(np.float64), 20.0 * cost * self.distances))

    def to(self, cell: tuple[int, int]) -> Floats:
        """Return the path to an exit, `(N, 2) float64` of `(row, column)`, the start left out."""
        cells = [cell]
        while self._before[cells[-1]] != cells[-1]:
            cells.append(self._before[cells[-1]])
        return np.array(cells[-2::-1], dtype=np.float64).reshape(-1, 2)


def lead_out(
    pose: SE2,
    costmap: Costmap,
    footprint: Footprint,
    radius: float = 0.0,
    reach: float = 0.5,
    touches: Callable[[SE2], bool] | None = None,
) -> Floats:
    """Return the poses `(N, 3)` straight off what the robot touches, its own first.

    There is only its own where it touches nothing, or does not get off within the reach [m], or
    where its middle would have to pass an obstacle's cell beside its own.

    Args:
        radius: Of the tightest bend of a steered drive, which leaves in bends, too; else 0 [m].
        reach: Greatest length [m].
        touches: Whether it touches something at a pose; if None, by the cells below its outline.
    """
    bends = (0.0, 1.0 / radius, -1.0 / radius) if radius > 0.0 else (0.0,)
    lines = lines_off(pose, costmap, touches or partial(collides, costmap, footprint), bends, reach)
    free = (line for line in lines if first_collision(costmap, footprint, line) is None)
    return min(free, key=len, default=pose.array()[None, :])


def lines_off(
    pose: SE2,
    costmap: Costmap,
    touches: Callable[[SE2], bool],
    bends: Sequence[float],
    reach: float = 0.5,
    step: float = 0.02,
) -> Iterator[Floats]:
    """Give the poses `(N, 3)` to where the robot touches nothing, its own first, by each way.

    Ahead and back, with each curvature [1/m]; none is longer than the reach [m], nor does its
    middle pass an obstacle's cell beside its own. Two poses are a step apart [m].
    """
    own = costmap.frame.to_cell(pose.x, pose.y)
    for bend, side in itertools.product(bends, (step, -step)):
        line = [pose]
        while len(line) * step < reach and touches(line[-1]):
            path = side * len(line)
            line.append(pose @ SE2.exp(np.array([path, 0.0, path * bend])))
            cell = costmap.frame.to_cell(line[-1].x, line[-1].y)
            if cell != own and costmap.cost_at(line[-1].x, line[-1].y) == LETHAL:
                break
        if not touches(line[-1]):
            yield np.array([each.array() for each in line])
