"""The Savitzky-Golay smoother: each point on the quadratic that fits its neighbours best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.smoothers.base import SmoothResult, in_passes

_WEIGHTS = np.array([-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0]) / 21.0
"""A quadratic of seven points at its middle."""
_REACH = len(_WEIGHTS) // 2


@dataclass(frozen=True)
class SavitzkyGolayConfig:
    """Parameters of the Savitzky-Golay smoother, by Nav2's names."""

    do_refinement: bool = param(True, "Whether to smooth the smoothed path again.")
    refinement_num: int = param(2, "How many times again.", minimum=0)


class SavitzkyGolaySmoother:
    """Fits a running quadratic: takes noise off and keeps the form; both ends stay.

    Args:
        config: How often.

    Source: Savitzky and Golay, Analytical Chemistry 36, 1964; nav2_smoother.
    """

    Config: ClassVar[type[Any]] = SavitzkyGolayConfig

    def __init__(self, config: SavitzkyGolayConfig) -> None:
        self._config = config

    def smooth(self, path: NDArray[np.float64], costmap: Costmap) -> SmoothResult:
        """Smooth a path; a pass that would touch an obstacle is undone and ends it."""
        passes = 1 + self._config.refinement_num * self._config.do_refinement
        return in_passes(path, costmap, passes, _fitted)


def _fitted(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points `(N, 2)` on the quadratics of seven; beyond an end it is mirrored there."""
    before = 2.0 * points[0] - points[_REACH:0:-1]
    after = 2.0 * points[-1] - points[-2 : -2 - _REACH : -1]
    padded = np.vstack((before, points, after))
    if len(padded) < len(points) + 2 * _REACH:  # too short to be noisy
        unchanged: NDArray[np.float64] = points.copy()
        return unchanged
    fitted: NDArray[np.float64] = np.column_stack(
        [np.convolve(column, _WEIGHTS, "valid") for column in padded.T]
    )
    fitted[0], fitted[-1] = points[0], points[-1]
    return fitted
