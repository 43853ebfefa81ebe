"""Regular 2D grids: where a cell lies, and the occupancy grid that maps are exchanged in."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.se2 import IDENTITY, SE2

UNKNOWN = -1
FREE = 0
OCCUPIED = 100


@dataclass(frozen=True)
class GridFrame:
    """A grid's pose and size: cell (row, column) covers `resolution` squared, row 0 lowest in y.

    Attributes:
        resolution: Edge of a cell [m].
        width: Number of columns (x).
        height: Number of rows (y).
        origin: Pose of the lower-left corner of cell (0, 0) in the grid's frame.
    """

    resolution: float
    width: int
    height: int
    origin: SE2 = IDENTITY

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, the shape of an array over this grid."""
        return self.height, self.width

    def to_cells(self, points: Floats) -> Ints:
        """Return the `(row, column)` of each point, `(N, 2)` [m] to `(N, 2) int64`.

        Cells outside the grid come back as they fall, negative or too large.
        """
        local = self.origin.inverse().apply(points) / self.resolution
        return np.floor(local[:, ::-1]).astype(np.int64)

    def to_points(self, cells: Ints) -> Floats:
        """Return the centres [m] of cells `(N, 2)` of `(row, column)`, as `(N, 2) float64`."""
        corners = cells[:, ::-1].astype(np.float64)
        return self.origin.apply((corners + 0.5) * self.resolution)

    def to_cell(self, x: float, y: float) -> tuple[int, int]:
        """Return the `(row, column)` of one point [m]; it may lie outside the grid."""
        row, column = self.to_cells(np.array([[x, y]]))[0]
        return int(row), int(column)

    def to_point(self, row: int, column: int) -> tuple[float, float]:
        """Return the centre [m] of one cell."""
        x, y = self.to_points(np.array([[row, column]]))[0]
        return float(x), float(y)

    def contains(self, row: int, column: int) -> bool:
        """Return whether the cell lies in the grid."""
        return 0 <= row < self.height and 0 <= column < self.width

    @property
    def span(self) -> str:
        """The grid's reach [m] along the axes of its frame, as a text for messages."""
        w, h = self.width * self.resolution, self.height * self.resolution
        corners = self.origin.apply(np.array([[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]]))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return f"x {x0:.2f} to {x1:.2f} m, y {y0:.2f} to {y1:.2f} m"

    def inside(self, cells: Ints) -> Bools:
        """Return for each of `(N, 2)` cells whether it lies in the grid, `(N,) bool`."""
        return (
            (cells[:, 0] >= 0)
            & (cells[:, 0] < self.height)
            & (cells[:, 1] >= 0)
            & (cells[:, 1] < self.width)
        )


def replace_cells(
    cells: NDArray[Any], x: int, y: int, width: int, height: int, values: Any
) -> None:
    """Replace a rectangle of cells, from a column and row on, in place.

    Raises:
        ValueError: It does not lie within the grid, or there are not as many values.
    """
    part = cells[y : y + height, x : x + width]
    if min(x, y) < 0 or part.shape != (height, width) or len(values) != part.size:
        rows, columns = cells.shape
        problem = f"an update of {width} x {height} cells at ({x}, {y}) with {len(values)} values"
        raise ValueError(f"{problem} does not fit into a grid of {columns} x {rows}")
    part[:] = np.asarray(values, cells.dtype).reshape(part.shape)


@dataclass(frozen=True)
class OccupancyGrid:
    """A map: occupancy in per cent, as nav_msgs/OccupancyGrid has it.

    Attributes:
        data: `(height, width) int8`, -1 unknown, 0 free to 100 occupied.
        stamp: Time of the map [s].
    """

    frame: GridFrame
    data: NDArray[np.int8]
    stamp: float = field(default=0.0)

    def __post_init__(self) -> None:
        if self.data.shape != self.frame.shape:
            raise ValueError(f"data has shape {self.data.shape}, the frame {self.frame.shape}")

    def occupied(self, threshold: int = 65) -> Bools:
        """Return the mask of cells at or above a threshold [%], `(height, width) bool`."""
        return self.data >= threshold

    def free(self, threshold: int = 25) -> Bools:
        """Return the mask of known cells at or below a threshold [%], `(height, width) bool`."""
        return (self.data >= 0) & (self.data <= threshold)

    def unknown(self) -> Bools:
        """Return the mask of unknown cells, `(height, width) bool`."""
        return self.data < 0
