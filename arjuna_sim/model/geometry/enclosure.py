"""What walls close off: the places of a world that nobody reaches from outside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

_CELL, _CELLS_MAX = 0.05, 600  # of the grid that walls are drawn on [m], and along each side
_MOST = 0.3  # of the grid that an enclosure takes at least: else it is a room beside the open
_EDGE = 3  # cells outside the walls, all around
_NEAR, _EACH = 3000, 10  # cells inside that are looked at, and every how many-th


@dataclass(frozen=True)
class Enclosure:
    """The largest place that walls close off.

    Attributes:
        origin: The lower left corner of the grid's first cell, `(2,) float64` [m].
        cell: A cell's side [m].
        inside: Whether the middle of a robot may be there, by row (y) and column (x).
        outside: Whether it is outside all walls.
    """

    origin: NDArray[np.float64]
    cell: float
    inside: NDArray[np.bool_]
    outside: NDArray[np.bool_]

    def is_outside(self, x: float, y: float) -> bool:
        """Return whether a point [m] is outside all walls."""
        column, row = np.floor((np.array([x, y]) - self.origin) / self.cell).astype(int).tolist()
        rows, columns = self.outside.shape
        return not (0 <= row < rows and 0 <= column < columns) or bool(self.outside[row, column])

    def nearest_inside(self, x: float, y: float) -> NDArray[np.float64]:
        """Return some places inside, the nearest to a point [m] first, `(N, 2) float64` [m]."""
        places = (np.argwhere(self.inside)[:, ::-1] + 0.5) * self.cell + self.origin
        nearest = np.argsort(np.hypot(*(places - (x, y)).T), kind="stable")[:_NEAR:_EACH]
        return places[nearest]


def enclosure_of(segments: NDArray[np.float64], radius: float) -> Enclosure | None:
    """Return what walls close off for a robot; None where they enclose too little to be a world.

    Args:
        segments: Surfaces of the walls, `(N, 4) float64` of `(x0, y0, x1, y1)` [m].
        radius: Of the robot, which passes no narrower gap than twice that [m].
    """
    if not len(segments):
        return None
    points = segments.reshape(-1, 2)
    size = np.ptp(points, axis=0)
    cell = max(_CELL, float(size.max()) / _CELLS_MAX)
    margin = radius + _EDGE * cell
    origin = points.min(axis=0) - margin
    columns, rows = np.ceil((size + 2.0 * margin) / cell).astype(int).tolist()
    walls = np.zeros((rows, columns), np.bool_)
    ends = segments.reshape(-1, 2, 2)
    counts = (np.hypot(*(ends[:, 1] - ends[:, 0]).T) / cell * 2.0).astype(int) + 2
    each = np.repeat(np.arange(len(ends)), counts)
    along = (np.arange(len(each)) - np.repeat(np.cumsum(counts) - counts, counts)) / (
        counts[each] - 1
    )
    at = ends[each, 0] + along[:, None] * (ends[each, 1] - ends[each, 0])
    index = ((at - origin) / cell).astype(int)
    walls[index[:, 1], index[:, 0]] = True
    free = ndimage.distance_transform_edt(~walls) * cell > radius
    labels, _ = ndimage.label(free)
    outside = labels == labels[0, 0]
    sizes = np.bincount(labels[free & ~outside], minlength=1)
    if not len(sizes) or sizes.max() < _MOST * walls.size:
        return None
    return Enclosure(origin, cell, labels == sizes.argmax(), outside)
