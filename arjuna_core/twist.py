"""The motion of a robot that cannot move sideways."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Velocity:
    """A planar twist of the robot's base without its sideways part.

    Attributes:
        v: Forward speed [m/s].
        w: Yaw rate, counter-clockwise [rad/s].
    """

    v: float = 0.0
    w: float = 0.0


STILL = Velocity()
