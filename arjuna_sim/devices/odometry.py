"""Dead reckoning from wheel encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.devices.drive import Kinematics


@dataclass(frozen=True)
class OdometryConfig:
    """Encoders, and how far dead reckoning is trusted."""

    ticks_per_revolution: int = param(
        4096, "Encoder ticks of one wheel turn.", minimum=1, maximum=10_000_000, read_only=True
    )
    encoder_noise: float = param(
        0.0, "Standard deviation of an encoder's reading.", unit="ticks", minimum=0.0
    )
    linear_noise: float = param(
        0.01, "Standard deviation of path, per root of path.", unit="m/sqrt(m)", minimum=0.0
    )
    angular_noise: float = param(
        0.02, "Standard deviation of turn, per root of turn.", unit="sqrt(rad)", minimum=0.0
    )
    drift_noise: float = param(
        0.01, "Standard deviation of turn, per root of path.", unit="rad/sqrt(m)", minimum=0.0
    )


@dataclass(frozen=True)
class OdometryEstimate:
    """Where the wheels say the robot is.

    Attributes:
        T_odom_base: Pose since the start.
        v: Speed [m/s].
        w: Turn rate [rad/s].
        covariance: Of the pose (x, y, theta), `(3, 3) float64`, in the odom frame.
        twist_variance: Of v and w [m^2/s^2, rad^2/s^2].
    """

    T_odom_base: SE2
    v: float
    w: float
    covariance: NDArray[np.float64]
    twist_variance: tuple[float, float]


class Odometry:
    """Integrates encoder ticks; what slips goes unnoticed.

    Args:
        config: Encoders and noise.
        kinematics: How wheels move the base.
        rng: Where the encoders' noise comes from.
    """

    def __init__(
        self, config: OdometryConfig, kinematics: Kinematics, rng: np.random.Generator
    ) -> None:
        self.config = config
        self._rng = rng
        self._kinematics = kinematics
        self._angle_per_tick = 2.0 * math.pi / config.ticks_per_revolution
        self.reset((0.0, 0.0))

    def reset(self, wheels: tuple[float, float]) -> None:
        """Start again at the origin, with the left and right wheels' mean angles [rad]."""
        self._ticks = self._to_ticks(wheels)
        self._pose = IDENTITY
        self._covariance = np.zeros((3, 3))

    def update(self, wheels: tuple[float, float], dt: float) -> OdometryEstimate:
        """Add one step.

        Args:
            wheels: Left and right wheels' mean angles [rad].
            dt: Time since the last update [s].

        Returns:
            The estimate, along the arc of constant turn rate that the ticks tell.
        """
        ticks = self._to_ticks(wheels)
        left, right = (
            (new - old) * self._angle_per_tick for new, old in zip(ticks, self._ticks, strict=True)
        )
        self._ticks = ticks
        path, turn = self._kinematics.base_motion(left, right)
        variance_path, variance_turn = self._grow(path, turn)
        self._pose = self._pose @ SE2.exp(np.array([path, 0.0, turn]))
        twist_variance = (variance_path / dt**2, variance_turn / dt**2)
        return OdometryEstimate(
            self._pose, path / dt, turn / dt, self._covariance.copy(), twist_variance
        )

    def _to_ticks(self, wheels: tuple[float, float]) -> tuple[int, int]:
        noise = self.config.encoder_noise
        errors = noise * self._rng.standard_normal(2) if noise > 0.0 else (0.0, 0.0)
        left, right = (
            round(angle / self._angle_per_tick + error)
            for angle, error in zip(wheels, errors, strict=True)
        )
        return left, right

    def _grow(self, path: float, turn: float) -> tuple[float, float]:
        """Propagate the covariance by the motion's Jacobians, at the middle heading."""
        config = self.config
        variance_path = config.linear_noise**2 * abs(path)
        variance_turn = config.angular_noise**2 * abs(turn) + config.drift_noise**2 * abs(path)
        heading = self._pose.theta + turn / 2
        c, s = math.cos(heading), math.sin(heading)
        by_pose = np.array([[1.0, 0.0, -path * s], [0.0, 1.0, path * c], [0.0, 0.0, 1.0]])
        by_motion = np.array([[c, -path * s / 2], [s, path * c / 2], [0.0, 1.0]])
        self._covariance = by_pose @ self._covariance @ by_pose.T
        self._covariance += (by_motion * (variance_path, variance_turn)) @ by_motion.T
        return variance_path, variance_turn
