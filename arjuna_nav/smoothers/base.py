"""What smoothing a path returns."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_nav.costmap.costmap import Costmap


class SmoothStatus(enum.IntEnum):
    """How smoothing ended; the values are nav2_msgs/action/SmoothPath's error codes."""

    SUCCEEDED = 0
    UNKNOWN = 500
    INVALID_SMOOTHER = 501
    TIMEOUT = 502
    SMOOTHED_PATH_IN_COLLISION = 503
    FAILED_TO_SMOOTH_PATH = 504
    INVALID_PATH = 505


@dataclass(frozen=True, eq=False)
class SmoothResult:
    """A smoothed path, or the path as it was and why.

    Attributes:
        status: How smoothing ended.
        path: `(N, 3) float64` [m, m, rad].
        message: What went wrong; empty on success.
    """

    status: SmoothStatus
    path: NDArray[np.float64]
    message: str = ""

    @staticmethod
    def failed(status: SmoothStatus, message: str) -> SmoothResult:
        """Return a result without path."""
        return SmoothResult(status, np.empty((0, 3)), message)


class Smoother(Protocol):
    """Smooths a path; made of its `Config`, the dataclass of its parameters."""

    def smooth(self, path: NDArray[np.float64], costmap: Costmap) -> SmoothResult:
        """Smooth a path `(N, 3)` of the costmap's frame; both ends stay."""
        ...
