"""NavFn's potential, plainly: all cells at once until nothing falls any more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def plain_potential(
    data: NDArray[np.uint8], costs: NDArray[np.float32], seeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what `spread` returns, `(height, width) float64`, by the formula alone."""
    cost = np.pad(costs[data].astype(np.float64), 1, constant_values=np.inf)
    values = np.full(cost.shape, np.inf)
    rows, columns = seeds[:, :2].astype(int).T + 1
    values[rows, columns] = seeds[:, 2]
    middle, open_ = (slice(1, -1), slice(1, -1)), np.isfinite(cost[1:-1, 1:-1])
    while True:
        across = np.minimum(values[1:-1, :-2], values[1:-1, 2:])
        along = np.minimum(values[:-2, 1:-1], values[2:, 1:-1])
        low = np.minimum(across, along)
        with np.errstate(invalid="ignore"):
            ratio = np.abs(across - along) / cost[middle]
            fit = 0.7040 + 0.5307 * ratio - 0.2301 * ratio**2
            fitted = low + cost[middle] * np.where(ratio < 1.0, fit, 1.0)
        found = np.where(open_ & (fitted < values[middle] - 1e-9), fitted, values[middle])
        if (found == values[middle]).all():
            return found
        values[middle] = found
