"""The parameters of a drive, its kinematics, and those of skid steering."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, length_param, param, speed_param, yaw_rate_param
from arjuna_core.twist import Velocity
from arjuna_sim.model.settings import DriveSettings

_NONE = np.zeros(0)


@dataclass(frozen=True)
class DriveConfig:
    """Limits of the base instead of those of the robot's file, and what calibration found."""

    max_linear_velocity: float | None = speed_param(
        None, "Greatest speed; none takes what the robot's file says, if anything."
    )
    max_angular_velocity: float | None = yaw_rate_param(
        None, "Greatest turn rate; none takes what the robot's file says, if anything."
    )
    max_linear_acceleration: float | None = param(
        None,
        "Greatest change of speed, as far as the wheels hold; none takes what the file says.",
        unit="m/s^2",
        minimum=0.01,
    )
    max_angular_acceleration: float | None = param(
        None,
        "Greatest change of turn rate, as far as the wheels hold; none takes what the file says.",
        unit="rad/s^2",
        minimum=0.01,
    )
    command_timeout: float | None = duration_param(
        None,
        "A command holds so long at least, and for one and a half periods of whoever sends them;"
        " 0 holds for ever; none takes the cmd_vel_timeout of the robot's controllers, which holds"
        " for just that, else 0.5 s.",
    )
    command_timeout_max: float = duration_param(
        3.0,
        "A slow sender's command ends at the latest after so long, if command_timeout is less.",
        minimum=0.02,
    )
    effective_track_width: float = length_param(
        0.0,
        "Track of the ideal two-wheeled robot that turns like this one as its wheels slip;"
        " 0 takes the URDF's, else its wheel separation.",
        read_only=True,
    )
    effective_wheel_radius: float = length_param(
        0.0, "Radius that makes wheel turns into distance; 0 takes the URDF's.", read_only=True
    )


class Base(ABC):
    """The kinematics of a drive; wheels are in the order of `DriveSettings.wheels`."""

    def reachable(self, velocity: Velocity) -> Velocity:
        """Return what of a velocity the base can do."""
        return velocity

    @abstractmethod
    def speeds(self, velocity: Velocity) -> Floats:
        """Return how fast the wheels' joints turn for a reachable velocity, `(W,)` [rad/s]."""

    def speeds_at(self, velocity: Velocity, angles: Floats) -> Floats:
        """Return the same where the steering joints still stand at other angles [rad]."""
        return self.speeds(velocity)

    def angles(self, velocity: Velocity) -> Floats:
        """Return where the steering joints stand for it, `(S,) float64` [rad]."""
        return _NONE

    def encoders(self, joints: Floats) -> Floats:
        """Return what encoders count at the wheels' joints' positions, `(W,)` [rad]."""
        return joints

    @abstractmethod
    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the encoders [rad]."""


@dataclass(frozen=True)
class Kinematics(Base):
    """An ideal two-wheeled robot that stands for the skid-steer one.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007
    (symmetric case: one effective track).

    Attributes:
        track: Effective track width [m].
        radius: Effective wheel radius [m].
    """

    track: float
    radius: float

    def speeds(self, velocity: Velocity) -> Floats:
        """Return the left and right wheels' speeds for a velocity of the base, `(2,)` [rad/s]."""
        across = velocity.yaw_rate * self.track / 2
        return np.array((velocity.x - across, velocity.x + across)) / self.radius

    def base_motion(self, left: float, right: float) -> tuple[float, float]:
        """Return path [m] and turn [rad] for the left and right wheels' turns [rad], or rates."""
        mean, difference = (left + right) / 2, right - left
        return mean * self.radius, difference * self.radius / self.track

    def motion(self, turns: Floats, angles: Floats) -> tuple[float, float, float]:
        """Return path [m], path to the left [m] and turn [rad] for turns of the sides [rad]."""
        left, right = turns.tolist()
        path, turn = self.base_motion(left, right)
        return path, 0.0, turn


def kinematics_of(settings: DriveSettings, config: DriveConfig) -> Kinematics:
    """Return what was calibrated, or else what the robot's file says."""
    return Kinematics(
        config.effective_track_width or settings.effective_track,
        config.effective_wheel_radius or settings.effective_radius,
    )
