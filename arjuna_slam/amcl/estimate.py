"""The estimate: what the filter concludes, and how far it can be trusted."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig

_PSD_TOLERANCE = 1e-9


class LocalizationError(ArjunaError, ValueError):
    """A pose, a covariance, a map or a limit cannot be used for localization."""


def check_map(grid: OccupancyGrid) -> None:
    """Raise unless the map has a resolution and free cells; one without obstacles shows nothing.

    Raises:
        LocalizationError: A robot cannot be anywhere in the map.
    """
    if not 0.0 < grid.frame.resolution < math.inf:
        raise LocalizationError(
            f"the map's resolution must be positive, got {grid.frame.resolution} m"
        )
    if not grid.free().any():
        raise LocalizationError(
            f"the map ({grid.frame.width} x {grid.frame.height} cells) has no free cell"
        )


def check_finite(pose: SE2, name: str) -> None:
    """Raise LocalizationError unless a pose is finite."""
    if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
        raise LocalizationError(f"{name} must be finite, got {pose}")


def check_inside(pose: SE2, frame: GridFrame) -> None:
    """Raise unless a pose [m] of the map frame lies on a map.

    Raises:
        LocalizationError: The pose lies outside; the message gives the map's extent.
    """
    if not frame.contains(*frame.to_cell(pose.x, pose.y)):
        raise LocalizationError(
            f"pose ({pose.x:.2f}, {pose.y:.2f}) m lies outside the map, which spans {frame.span}"
        )


def covariance_root(covariance: Floats) -> Floats:
    """Return a matrix L `(3, 3)` with `L @ L.T` the covariance `(3, 3)` of x, y, theta.

    Raises:
        LocalizationError: It is no finite, symmetric, positive semi-definite (3, 3) matrix.
    """
    covariance = np.asarray(covariance, dtype=np.float64)
    if covariance.shape != (3, 3) or not np.isfinite(covariance).all():
        raise LocalizationError("the covariance of x, y, theta must be a finite (3, 3) matrix")
    if not np.allclose(covariance, covariance.T, atol=_PSD_TOLERANCE):
        raise LocalizationError("the covariance of x, y, theta must be symmetric")
    values, vectors = np.linalg.eigh(covariance)
    if values[0] < -_PSD_TOLERANCE:
        raise LocalizationError(
            f"the covariance of x, y, theta must be positive semi-definite, "
            f"its least eigenvalue is {values[0]:.3g}"
        )
    root: Floats = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


class Status(enum.Enum):
    """Outcome of an update of the filter."""

    TRACKING = "tracking"
    AMBIGUOUS = "ambiguous"
    LOST = "lost"
    BLIND = "blind"


@dataclass(frozen=True)
class Estimate:
    """The estimated pose of the robot, and how far to trust it."""

    T_map_base: SE2  # pose of the base in the map
    T_map_odom: SE2  # pose of the odometry frame in the map
    covariance: Floats  # of x, y, theta, `(3, 3) float64` [m, m, rad], of the heaviest cluster
    quality: float  # trust, 0..1: the share of beams that agree times the share of the weight
    reason: str  # what the quality rests on, one sentence
    status: Status  # how the update ended


@dataclass(frozen=True)
class Hypothesis:
    """A pose that the robot may have."""

    T_map_base: SE2  # pose of the base in the map
    covariance: Floats  # of x, y, theta, `(3, 3) float64` [m, m, rad]
    # share of beams that agree with the map there, 0..1; None if too few returned
    agreement: float | None
    share: float  # its probability among the hypotheses, 0..1


def conclude(best: Hypothesis, T_odom_base: SE2, config: AmclConfig) -> Estimate:
    """Return what the best hypothesis amounts to, with the odometry at its time."""
    T_map_odom = best.T_map_base @ T_odom_base.inverse()
    status, reason = _judge(best, config)
    quality = (best.agreement or 0.0) * best.share
    return Estimate(best.T_map_base, T_map_odom, best.covariance, quality, reason, status)


def _judge(best: Hypothesis, config: AmclConfig) -> tuple[Status, str]:
    if best.agreement is None:
        return Status.BLIND, "hardly a beam shows what the map knows; odometry alone"
    agree = f"{best.agreement:.0%} of the beams agree with the map"
    if best.agreement < config.relocalize_agreement:
        return Status.LOST, f"only {agree}"
    if best.share < config.tracking_share:
        return Status.AMBIGUOUS, f"{agree}, but other poses explain {1 - best.share:.0%}"
    return Status.TRACKING, agree


@dataclass
class Track:
    """The last conclusion, and the odometry that it rests on."""

    # odometry at the last update of the particles; None after a new start
    updated_at: SE2 | None = None
    best: Hypothesis | None = None  # the hypothesis that was believed last; None after a new start
    estimate: Estimate | None = None  # what it amounted to

    def due(self, T_odom_base: SE2, config: AmclConfig) -> bool:
        """Return whether the robot moved enough, each coordinate by itself as in nav2_amcl."""
        if self.updated_at is None:
            return True
        last = self.updated_at
        far = max(abs(T_odom_base.x - last.x), abs(T_odom_base.y - last.y)) > config.update_min_d
        return far or abs(wrap(T_odom_base.theta - last.theta)) > config.update_min_a

    def step(self, T_odom_base: SE2) -> SE2 | None:
        """Return the motion since the last update of the particles, and begin the next step."""
        last, self.updated_at = self.updated_at, T_odom_base
        return None if last is None else last.inverse() @ T_odom_base

    def conclude(self, best: Hypothesis, T_odom_base: SE2, config: AmclConfig) -> Estimate:
        """Believe a hypothesis; return what it amounts to.

        One that no scan supports is no reason to leave the pose to which odometry leads.
        """
        jump = 0.5  # [m, rad] from odometry, beyond which no scan has corrected a pose
        estimate = conclude(best, T_odom_base, config)
        if self.estimate is not None and estimate.status is Status.LOST:
            led = self.estimate.T_map_odom @ T_odom_base
            step = led.inverse() @ best.T_map_base
            if math.hypot(step.x, step.y) > jump or abs(step.theta) > jump:
                best = replace(best, T_map_base=led)
                estimate = conclude(best, T_odom_base, config)
        self.best, self.estimate = best, estimate
        return estimate
