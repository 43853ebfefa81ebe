"""Which way is up for the robot, as its IMU feels: one that has overturned drives nowhere."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, fixed
from arjuna_core.geodesy import GRAVITY

_MEAN = 1.0  # time over which forces are averaged, and after which a silent IMU counts no more [s]
_FELT = 0.5  # of gravity: an IMU that reports less has taken gravity off


@dataclass(frozen=True)
class PostureConfig:
    """Parameters by which an overturned robot is noticed."""

    imu_topic: str = fixed(
        "imu/data", "Topic of the IMU by which an overturned robot is noticed; empty: none."
    )
    overturned_tilt: float = angle_param(
        1.0,
        "Tilt from which the robot has overturned, and goals end; 0: never, as Nav2.",
        maximum=math.pi,
        theirs=0.0,
    )


class Posture:
    """The mean of the forces that the robot has felt lately.

    At rest an accelerometer feels 1 g upward; braking and bumps are over in less than a second.

    Attributes:
        felt_at: When it felt one last [s].
    """

    def __init__(self) -> None:
        self._force, self.felt_at, self._began = np.zeros(3), -math.inf, math.inf
        self._up, self._tilt = np.array([0.0, 0.0, 1.0]), math.nan

    def feel(self, force: Floats, now: float) -> None:
        """Take a specific force in the base's frame `(3,)` [m/s^2] at a time [s]."""
        self._began = min(self._began, now)
        passed = now - self.felt_at
        share = passed / _MEAN if 0.0 <= passed < _MEAN else 1.0
        self._force = self._force + share * (force - self._force)
        self.felt_at = now
        size = float(np.linalg.norm(self._force))
        cosine = float(self._force @ self._up) / max(size, 1e-9)
        self._tilt = math.nan if size < _FELT * GRAVITY else math.acos(max(-1.0, min(1.0, cosine)))

    def tilt(self, now: float) -> float | None:
        """Return the angle between the robot's z axis and up [rad].

        It is None in the first second, and where gravity is not felt.
        """
        felt = 0.0 <= now - self.felt_at <= 2.0 * _MEAN
        unknown = not felt or math.isnan(self._tilt) or now - self._began < _MEAN
        return None if unknown else self._tilt

    def take_as_upright(self) -> None:
        """Take the robot for upright now, whichever way its IMU is said to be mounted."""
        self._up, self._tilt = self._force / float(np.linalg.norm(self._force)), 0.0
