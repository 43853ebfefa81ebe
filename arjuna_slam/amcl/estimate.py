"""The estimate: what the filter concludes, and how far it can be trusted."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2

_SURE = 0.75  # share of the weight above which the heaviest cluster is the answer


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
    """

    T_map_base: SE2
    T_map_odom: SE2
    covariance: NDArray[np.float64]
    quality: float
    reason: str
    status: Status


@dataclass(frozen=True)
class Answer:
    """The hypothesis that wins.

    Attributes:
        pose: `(3,) float64` in the map frame [m, m, rad].
        covariance: `(3, 3) float64`.
        agreement: Share of beams that agree with the map there, 0..1; None if too few returned.
        share: Its probability among the hypotheses, 0..1.
    """

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    agreement: float | None
    share: float


def conclude(answer: Answer, T_odom_base: SE2, least: float) -> Estimate:
    """Say what an answer amounts to.

    Args:
        answer: The hypothesis that wins.
        T_odom_base: Odometry at its time.
        least: Agreement below which the robot is lost, 0..1.
    """
    T_map_base = SE2.from_array(answer.pose)
    T_map_odom = T_map_base @ T_odom_base.inverse()
    status, reason = _judge(answer, least)
    quality = (answer.agreement or 0.0) * answer.share
    return Estimate(T_map_base, T_map_odom, answer.covariance, quality, reason, status)


def _judge(answer: Answer, least: float) -> tuple[Status, str]:
    if answer.agreement is None:
        return Status.BLIND, "hardly a beam returned; odometry alone"
    agree = f"{answer.agreement:.0%} of the beams agree with the map"
    if answer.agreement < least:
        return Status.LOST, f"only {agree}"
    if answer.share < _SURE:
        return Status.AMBIGUOUS, f"{agree}, but other places explain {1 - answer.share:.0%}"
    return Status.TRACKING, agree
