"""The estimate: what the filter concludes, and how far it can be trusted."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig


class Status(enum.Enum):
    """How an update of the filter ended."""

    TRACKING = "tracking"
    AMBIGUOUS = "ambiguous"
    LOST = "lost"
    BLIND = "blind"


@dataclass(frozen=True)
class Estimate:
    """Where the robot is.

    Attributes:
        T_map_base: Pose of the base in the map.
        T_map_odom: Pose of the odometry frame in the map.
        covariance: Of x, y, theta, `(3, 3) float64` [m, m, rad], of the heaviest cluster.
        quality: Trust, 0..1: the share of beams that agree times the share of the weight.
        reason: What the quality rests on, one sentence.
        status: How the update ended.
        strayed: Whether it has been lost since it was put elsewhere than odometry led it: not a
            place to drive from.
    """

    T_map_base: SE2
    T_map_odom: SE2
    covariance: NDArray[np.float64]
    quality: float
    reason: str
    status: Status
    strayed: bool = False


@dataclass(frozen=True)
class Hypothesis:
    """A place where the robot may be.

    Attributes:
        T_map_base: Pose of the base in the map.
        covariance: Of x, y, theta, `(3, 3) float64` [m, m, rad].
        agreement: Share of beams that agree with the map there, 0..1; None if too few returned.
        share: Its probability among the hypotheses, 0..1.
    """

    T_map_base: SE2
    covariance: NDArray[np.float64]
    agreement: float | None
    share: float


def conclude(best: Hypothesis, T_odom_base: SE2, config: AmclConfig) -> Estimate:
    """Say what the best hypothesis amounts to.

    Args:
        best: The hypothesis.
        T_odom_base: Odometry at its time.
        config: Parameters.
    """
    T_map_odom = best.T_map_base @ T_odom_base.inverse()
    status, reason = _judge(best, config)
    quality = (best.agreement or 0.0) * best.share
    return Estimate(best.T_map_base, T_map_odom, best.covariance, quality, reason, status)


def _judge(best: Hypothesis, config: AmclConfig) -> tuple[Status, str]:
    if best.agreement is None:
        return Status.BLIND, "hardly a beam returned; odometry alone"
    agree = f"{best.agreement:.0%} of the beams agree with the map"
    if best.agreement < config.relocalize_agreement:
        return Status.LOST, f"only {agree}"
    if best.share < config.tracking_share:
        return Status.AMBIGUOUS, f"{agree}, but other places explain {1 - best.share:.0%}"
    return Status.TRACKING, agree
