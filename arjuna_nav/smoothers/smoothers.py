"""Smoothers: what they are, and the simple one and Savitzky and Golay's."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import length_param, param
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import wrap
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.query import oriented
from arjuna_nav.planners.relaxation import relax, touches


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
    path: Floats
    message: str = ""


class Smoother(Protocol):
    """Smooths a path; made of its `Config`, the dataclass of its parameters."""

    def smooth(self, path: Floats, costmap: Costmap) -> SmoothResult:
        """Smooth a path `(N, 3)` of the costmap's frame; both ends stay."""
        ...


def problem_of(path: Floats) -> str:
    """Return why an array is no path; empty where it is one."""
    if path.ndim != 2 or path.shape[1] != 3 or not len(path):
        return f"a path must be (N, 3) with N > 0, got {path.shape}"
    return ""


def between_turns(path: Floats) -> list[Floats]:
    """Return views of a path from one turn on the spot to the next; a pose within one is one."""
    return np.split(path, paths.turns(path) + 1)


def in_passes(
    path: Floats, costmap: Costmap, passes: int, once: Callable[[Floats], Floats], by_parts: bool
) -> SmoothResult:
    """Smooth a path part by part; a pass that would touch an obstacle is undone and ends its part.

    Args:
        path: `(N, 3) float64`; its ends stay, the poses where it changes its direction, and turns
            on the spot.
        costmap: Of the path's frame.
        passes: How many.
        once: Smooths points `(N, 2)` once.

    Source: nav2_smoother, findDirectionalPathSegments and updateApproximatePathOrientations.
    """
    if problem := problem_of(path):
        return SmoothResult(SmoothStatus.INVALID_PATH, path, problem)
    result, free = path.copy(), True
    for piece in between_turns(result) if by_parts else [result]:
        for first, last in paths.parts(piece) if by_parts else [(0, len(piece) - 1)]:
            part = piece[first : last + 1]
            reverse = by_parts and paths.directions(part) == [-1]
            points: Floats = np.ascontiguousarray(part[:, :2])
            for _ in range(passes if len(part) > 2 else 0):
                smoothed = once(points)
                if touches(smoothed, costmap):
                    free = False
                    break
                points = smoothed
            part[:] = oriented(points, float(part[-1, 2]))
            if reverse:
                part[:-1, 2] = wrap(part[:-1, 2] + math.pi)
    if free:
        return SmoothResult(SmoothStatus.SUCCEEDED, result)
    message = "smoothing would touch an obstacle; the path is as it was before"
    return SmoothResult(SmoothStatus.FAILED_TO_SMOOTH_PATH, result, message)


_SIMPLE = "nav2_smoother::SimpleSmoother"

SMOOTHERS = PluginTypes(
    "smoother",
    {
        _SIMPLE: "arjuna_nav.smoothers.smoothers:SimpleSmoother",
        "nav2_constrained_smoother::ConstrainedSmoother": (
            "arjuna_nav.smoothers.constrained:ConstrainedSmoother"
        ),
        "nav2_smoother::SavitzkyGolaySmoother": (
            "arjuna_nav.smoothers.smoothers:SavitzkyGolaySmoother"
        ),
    },
    _SIMPLE,
    stands_in=True,
)


_BY_PARTS = param(
    True, "Whether parts driven ahead and in reverse are smoothed apart, so that cusps stay."
)


@dataclass(frozen=True)
class SimpleSmootherConfig:
    """Parameters of the simple smoother, by Nav2's names."""

    tolerance: float = length_param(1e-10, "Change at which it has converged.")
    max_its: int = param(1000, "Most iterations.", minimum=1, maximum=100_000)
    w_data: float = param(0.2, "Weight of the given path.", minimum=0.0)
    w_smooth: float = param(0.3, "Weight of smoothness.", minimum=0.0)
    do_refinement: bool = param(True, "Whether to smooth the smoothed path again.")
    refinement_num: int = param(2, "How many times again.", minimum=0, maximum=20)
    enforce_path_inversion: bool = _BY_PARTS


class SimpleSmoother:
    """Pulls each point to its neighbours' middle and to where it was; both ends stay.

    Source: nav2_smoother, SimpleSmoother; Thrun, path smoothing by gradient descent.
    """

    Config: ClassVar[type[Any]] = SimpleSmootherConfig

    def __init__(self, config: SimpleSmootherConfig) -> None:
        self._config = config

    def smooth(self, path: Floats, costmap: Costmap) -> SmoothResult:
        config = self._config
        weights = config.w_data, config.w_smooth, config.tolerance, config.max_its
        passes = 1 + config.refinement_num * config.do_refinement
        by_parts = config.enforce_path_inversion
        return in_passes(path, costmap, passes, lambda points: relax(points, *weights), by_parts)


@dataclass(frozen=True)
class SavitzkyGolayConfig:
    """Parameters of the Savitzky-Golay smoother, by Nav2's names.

    Raises:
        ConfigError: The window is even, or has too few points for the order.
    """

    do_refinement: bool = param(True, "Whether to smooth the smoothed path again.")
    refinement_num: int = param(2, "How many times again.", minimum=0)
    mirrored_ends: bool = param(
        True,
        "Whether the path is mirrored beyond an end; else, as Nav2, its end repeats.",
        theirs=False,
    )
    window_size: int = param(7, "Points that a polynomial is fitted to.", minimum=3, maximum=99)
    poly_order: int = param(3, "Order of the polynomial.", minimum=0, maximum=10)
    enforce_path_inversion: bool = _BY_PARTS

    def __post_init__(self) -> None:
        size, order = self.window_size, self.poly_order
        if size % 2 == 0 or size <= order:
            valid = f"valid: an odd number above 'poly_order' {order}"
            raise ConfigError(f"'window_size' is {size}; {valid}")


class SavitzkyGolaySmoother:
    """Fits a running polynomial: takes noise off and keeps the form; both ends stay.

    Source: Savitzky and Golay, Analytical Chemistry 36, 1964; nav2_smoother.
    """

    Config: ClassVar[type[Any]] = SavitzkyGolayConfig

    def __init__(self, config: SavitzkyGolayConfig) -> None:
        self._config = config

    def smooth(self, path: Floats, costmap: Costmap) -> SmoothResult:
        config = self._config
        passes = 1 + config.refinement_num * config.do_refinement
        offsets = np.arange(config.window_size) - config.window_size // 2
        weights = np.linalg.pinv(np.vander(offsets, config.poly_order + 1))[-1]
        fitted = partial(_fitted, weights=weights, mirrored=config.mirrored_ends)
        return in_passes(path, costmap, passes, fitted, config.enforce_path_inversion)


def _fitted(points: Floats, weights: Floats, mirrored: bool) -> Floats:
    """Return points `(N, 2)` on polynomials; beyond an end the path is mirrored or repeats it."""
    reach = len(weights) // 2
    before, after = points[reach:0:-1], points[-2 : -2 - reach : -1]
    if mirrored:
        before, after = 2.0 * points[0] - before, 2.0 * points[-1] - after
    else:
        before, after = points[:1].repeat(len(before), 0), points[-1:].repeat(len(after), 0)
    padded = np.vstack((before, points, after))
    if len(padded) < len(points) + 2 * reach:  # too short to be noisy
        unchanged: Floats = points.copy()
        return unchanged
    fitted: Floats = np.column_stack([np.convolve(column, weights, "valid") for column in padded.T])
    fitted[0], fitted[-1] = points[0], points[-1]
    return fitted
