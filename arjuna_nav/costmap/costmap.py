"""A costmap: what it costs to have the robot's centre in each cell."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2

FREE = 0
MAX_NON_OBSTACLE = 252
INSCRIBED = 253
LETHAL = 254
UNKNOWN = 255
_STEPS = 65534.0  # of a cell's edge


def _occupancy_table() -> NDArray[np.int8]:
    """Return Nav2's translation: 0 to 0, 1..252 to 1..98, 253 to 99, 254 to 100, 255 to -1."""
    table = np.zeros(256, dtype=np.int8)
    costs = np.arange(1, INSCRIBED)
    table[1:INSCRIBED] = 1 + 97 * (costs - 1) // 251
    table[INSCRIBED], table[LETHAL], table[UNKNOWN] = 99, 100, -1
    return table


_OCCUPANCY = _occupancy_table()


@dataclass(frozen=True, eq=False)
class Costmap:
    """Costs on a grid. What a `LayeredCostmap` holds is changed in place by its next update.

    Attributes:
        data: `(height, width) uint8`: 0 free, 1..252 near obstacles, 253 within the robot's
            inscribed radius of one, 254 lethal, 255 unknown.
        stamp: Time of the last update [s].
        circumscribed_cost: Cost at the robot's circumscribed radius from an obstacle: below it no
            heading collides. 0 where the inflation does not reach that far.
        circumscribed_radius: The robot's, of which that cost is [m].
        clearances: `(256,) float64` how far beyond its inscribed radius the robot is from an
            obstacle where a cost is [m]; inf where the cost does not show it.
        hits: `(height, width) uint32` where in their cells obstacles lie, as `hit_points` reads
            them; None where only the cells are known.
        moving: What moves: middles and radii in the grid, from its origin, `(K, 3)` [m].
        T_frame_own: Maps coordinates of the frame in which the layers keep the grid into `frame`'s.
        leaves: Whether a motion that begins in a collision may lead out of it.
        inflations: `circumscribed_cost`, `clearances` and the radius [m] by the name of each
            inflation layer.
    """

    frame: GridFrame
    data: Bytes
    stamp: float = 0.0
    circumscribed_cost: int = 0
    circumscribed_radius: float = math.inf
    clearances: Floats = field(default_factory=lambda: np.full(256, np.inf))
    hits: NDArray[np.uint32] | None = None
    moving: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    T_frame_own: SE2 = IDENTITY
    leaves: bool = True
    inflations: Mapping[str, tuple[int, Floats, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.data.shape != self.frame.shape:
            raise ValueError(f"data has shape {self.data.shape}, the frame {self.frame.shape}")

    def copied(self) -> Costmap:
        """Return the costs as of now, which no update changes."""
        hits = None if self.hits is None else self.hits.copy()
        return replace(self, data=self.data.copy(), hits=hits)

    def safe_cost(self, radius: float) -> int:
        """Return the cost below which no heading of an outline of a radius [m] collides."""
        return self.circumscribed_cost if radius <= self.circumscribed_radius else 0

    def cost_at(self, x: float, y: float) -> int | None:
        """Return the cost at a point [m] of the frame, None outside the grid."""
        row, column = self.frame.to_cell(x, y)
        return int(self.data[row, column]) if self.frame.contains(row, column) else None

    def obstacles(self, x: float, y: float, radius: float) -> Floats:
        """Return where obstacles are within a radius, `(N, 2) float64` [m] of the frame.

        Finer than the cells where scans have hit them, else the cells' middles.
        """
        T_frame_grid, cell = self.frame.origin, self.frame.resolution
        at = T_frame_grid.inverse().apply(np.array([[x, y]]))[0] / cell
        hits = np.zeros(self.frame.shape, np.uint32) if self.hits is None else self.hits
        points = hit_points(self.data, hits, float(at[0]), float(at[1]), radius / cell)
        return T_frame_grid.apply(points * cell)

    def moves_within(self, x: float, y: float, reach: float) -> bool:
        """Return whether anything moves nearer than a reach to a point [m] of the frame."""
        at = self.frame.origin.inverse().apply(np.array([[x, y]]))[0]
        gaps = np.hypot(*(self.moving[:, :2] - at).T) - self.moving[:, 2]
        return bool((gaps < reach).any())

    def seen_from(self, T_other_frame: SE2) -> Costmap:
        """Return the same costs with the grid placed in another frame; the data is shared."""
        frame = replace(self.frame, origin=T_other_frame @ self.frame.origin)
        return replace(self, frame=frame, T_frame_own=T_other_frame @ self.T_frame_own)


def occupancy_of(costs: Bytes) -> NDArray[np.int8]:
    """Return costs as nav_msgs/OccupancyGrid has them, of the same shape."""
    occupancy: NDArray[np.int8] = _OCCUPANCY[costs]
    return occupancy


@njit(cache=True)
def blended(code: int, x: float, y: float) -> int:
    """Return a cell's code after one more hit at a point in it [cells].

    The code is the mean of the latest hits: its lower 16 bits x, its upper y; 0 for no hit.
    """
    if code:
        x0, y0 = _decoded(code)
        # A hit weighs a quarter in its cell's mean: the noise of ranges is averaged.
        x, y = x0 + 0.25 * (x - x0), y0 + 0.25 * (y - y0)
    return 1 + int(x * _STEPS) + (int(y * _STEPS) << 16)


@njit(cache=True)
def _decoded(code: int) -> tuple[float, float]:
    return ((code & 0xFFFF) - 0.5) / _STEPS, ((code >> 16) + 0.5) / _STEPS


@njit(cache=True)
def hit_points(data: Bytes, hits: NDArray[np.uint32], x: float, y: float, radius: float) -> Floats:
    """Return where the lethal cells within a radius are marked, `(N, 2)` x, y [cells].

    A cell that no scan has hit, 0 in the `(height, width) uint32` hits, is marked in its middle.
    """
    height, width = data.shape
    rows = max(math.floor(y - radius), 0), min(math.floor(y + radius) + 1, height)
    columns = max(math.floor(x - radius), 0), min(math.floor(x + radius) + 1, width)
    found = []
    for row in range(rows[0], rows[1]):
        for column in range(columns[0], columns[1]):
            if data[row, column] == LETHAL:
                off = _decoded(hits[row, column]) if hits[row, column] else (0.5, 0.5)
                if math.hypot(column + off[0] - x, row + off[1] - y) <= radius:
                    found.append((column + off[0], row + off[1]))
    points = np.empty((len(found), 2))
    for i in range(len(found)):
        points[i, 0], points[i, 1] = found[i]
    return points
