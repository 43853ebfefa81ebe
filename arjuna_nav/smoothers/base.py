"""The protocol of smoothers, their result, and the list of them."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import wrap
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.query import oriented
from arjuna_nav.planners.relaxation import touches


class SmoothStatus(enum.IntEnum):
    """End of smoothing; the values are nav2_msgs/action/SmoothPath's error codes."""

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
        path: `(N, 3) float64` [m, m, rad].
        message: What went wrong; empty on success.
    """

    status: SmoothStatus
    path: NDArray[np.float64]
    message: str = ""


class Smoother(Protocol):
    """Smooths a path; made of its `Config`, the dataclass of its parameters."""

    def smooth(self, path: NDArray[np.float64], costmap: Costmap) -> SmoothResult:
        """Smooth a path `(N, 3)` of the costmap's frame; both ends stay."""
        ...


def in_passes(
    path: NDArray[np.float64],
    costmap: Costmap,
    passes: int,
    once: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    by_parts: bool,
) -> SmoothResult:
    """Smooth a path part by part; a pass that would touch an obstacle is undone and ends its part.

    Args:
        path: `(N, 3) float64`; its ends stay, and the poses where it changes its direction.
        costmap: Of the path's frame.
        passes: How many.
        once: Smooths points `(N, 2)` once.

    Source: nav2_smoother, findDirectionalPathSegments and updateApproximatePathOrientations.
    """
    if path.ndim != 2 or path.shape[1] != 3 or not len(path):
        message = f"a path must be (N, 3) with N > 0, got {path.shape}"
        return SmoothResult(SmoothStatus.INVALID_PATH, path, message)
    result, first, free = path.copy(), 0, True
    while first < len(path) - 1:
        end = paths.part_end(path, first) if by_parts else len(path)
        points: NDArray[np.float64] = np.ascontiguousarray(path[first:end, :2])
        for _ in range(passes):
            smoothed = once(points)
            if touches(smoothed, costmap):
                free = False
                break
            points = smoothed
        part = oriented(points, float(path[end - 1, 2]))
        if by_parts and math.cos(part[0, 2] - path[first, 2]) < 0.0:  # it is driven in reverse
            part[:-1, 2] = wrap(part[:-1, 2] + math.pi)
        result[first:end], first = part, end - 1
    if free:
        return SmoothResult(SmoothStatus.SUCCEEDED, result)
    message = "smoothing would touch an obstacle; the path is as it was before"
    return SmoothResult(SmoothStatus.FAILED_TO_SMOOTH_PATH, result, message)


_SIMPLE = "nav2_smoother::SimpleSmoother"

SMOOTHERS = PluginTypes(
    "smoother",
    {
        _SIMPLE: "arjuna_nav.smoothers.smoothers:SimpleSmoother",
        "nav2_smoother::SavitzkyGolaySmoother": (
            "arjuna_nav.smoothers.smoothers:SavitzkyGolaySmoother"
        ),
    },
    _SIMPLE,
)
