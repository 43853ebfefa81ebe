"""A field at rest: of a submap's grid a hundredth holds anything, so only that is kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_slam.matching.field import Field


@dataclass(frozen=True, eq=False)
class PackedField:
    """The cells of a field that hold anything, row by row.

    Attributes:
        resolution: Edge of a cell [m].
        sigma: Of the field [m].
        origin: Outer corner of cell (0, 0), `(2,) float64` [m].
        shape: Rows and columns.
        cells: Their numbers, `(N,) int32`.
        score: Their likelihoods, `(N,) uint8`.
        surface: Which of them have sums of a surface, `(N,) bool`.
        planes: Those sums in their order after a row for none, `(K + 1, 4) float32`.
    """

    resolution: float
    sigma: float
    origin: NDArray[np.float64]
    shape: tuple[int, int]
    cells: NDArray[np.int32]
    score: NDArray[np.uint8]
    surface: NDArray[np.bool_]
    planes: NDArray[np.float32]

    @staticmethod
    def of(field: Field) -> PackedField:
        """Return what a field holds."""
        cells = np.flatnonzero(field.score).astype(np.int32)
        rows = field.index.ravel()[cells]
        planes = field.planes[np.concatenate(([0], rows[rows > 0]))]
        height, width = field.score.shape
        return PackedField(
            field.resolution, field.sigma, field.origin, (height, width),
            cells, field.score.ravel()[cells], rows > 0, planes,
        )  # fmt: skip

    def unpacked(self) -> Field:
        """Return the field; nothing is to be added to it."""
        field = Field(self.resolution, self.sigma)
        field.origin, field.planes = self.origin, self.planes
        field.score = np.zeros(self.shape, np.uint8)
        field.score.ravel()[self.cells] = self.score
        count = len(self.planes)
        small = count <= np.iinfo(np.uint16).max + 1
        field.index = np.zeros(self.shape, np.uint16 if small else np.int32)
        field.index.ravel()[self.cells[self.surface]] = np.arange(1, count)
        return field
