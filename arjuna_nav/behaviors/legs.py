"""Motions of a few legs, closed by odometry alone: a turn, a straight drive, an arc.

Nothing looks out for obstacles: these are a student's square, and an iRobot Create 3's motions.

Source: irobot_create_nodes: DriveDistance, DriveArc, RotateAngle, NavigateToPosition, Undock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import InvalidGoalError
from arjuna_nav.controllers.tracker import Tracker, TrackerConfig


@dataclass(frozen=True)
class Leg:
    """One motion of constant curvature.

    Attributes:
        distance: To drive, negative backwards [m].
        angle: To turn by, meanwhile, positive to the left [rad].
        speed: The greatest one [m/s].
        rate: The greatest yaw rate [rad/s].
        start: Where it begins; None where the robot stands.
    """

    distance: float = 0.0
    angle: float = 0.0
    speed: float = 0.3
    rate: float = 1.9
    start: SE2 | None = None

    def __post_init__(self) -> None:
        values = (self.distance, self.angle, self.speed, self.rate)
        if not all(map(math.isfinite, values)) or min(self.speed, self.rate) <= 0.0:
            what = "distance {:g} m, angle {:g} rad, {:g} m/s, {:g} rad/s".format(*values)
            raise InvalidGoalError(f"{what}: all must be finite, the limits above 0")


Step = Callable[[SE2], Leg]
"""Returns a leg by the pose at its start."""


def arc(angle: float, radius: float, direction: int, speed: float) -> Leg:
    """Return a drive along an arc; the angle's sign is that of the turn.

    Raises:
        InvalidGoalError: The radius is none, or the direction is neither 1 nor -1.
    """
    if not radius > 0.0 or direction not in (-1, 1):
        raise InvalidGoalError(f"radius {radius:g} m, direction {direction}; valid: > 0, 1 or -1")
    return Leg(direction * abs(angle) * radius, angle, speed, speed / radius)


def turn_towards(x: float, y: float, rate: float = 1.9) -> Step:
    """Turn to face a position."""
    return lambda pose: Leg(angle=wrap(math.atan2(y - pose.y, x - pose.x) - pose.theta), rate=rate)


def to_position(goal: SE2, heading: bool, speed: float = 0.3, rate: float = 1.9) -> list[Step]:
    """Return the steps to a pose: turn to face it, drive, and turn to its heading if asked for."""
    steps: list[Step] = [
        turn_towards(goal.x, goal.y, rate),
        lambda pose: Leg(pose.distance(goal), speed=speed),
    ]
    if heading:
        steps.append(lambda pose: Leg(angle=wrap(goal.theta - pose.theta), rate=rate))
    return steps


class Legs:
    """Drives legs one after the other.

    Attributes:
        index: The leg that is driven.
        done: How far it has turned, if it is to turn, else come ahead [rad or m].
    """

    def __init__(self, steps: Sequence[Step], config: TrackerConfig) -> None:
        self._steps, self._config = steps, config
        self.index, self.done = -1, 0.0
        self._leg, self._tracker = Leg(), Tracker(config)
        self._start = self._last = SE2()

    @property
    def remaining(self) -> float:
        """Rest of the leg, [rad] if it turns, else [m]."""
        return abs((self._leg.angle or self._leg.distance) - self.done)

    def tick(self, pose: SE2, velocity: Velocity) -> Velocity | None:
        """Return what to drive at a measured velocity; None at the end."""
        while True:
            if self.index >= 0:
                self._lead(pose)
                command = self._tracker.compute(pose, velocity, self._leg.speed)
                if command is not None:
                    return command
            if self.index + 1 == len(self._steps):
                return None
            self.index += 1
            self._begin(self._steps[self.index](pose), pose)

    def _begin(self, leg: Leg, pose: SE2) -> None:
        self._leg, self._start, self.done = leg, leg.start or pose, 0.0
        self._last = self._start
        self._tracker = Tracker(replace(self._config, max_angular_velocity=leg.rate))
        if not leg.angle:
            self._follow(0.0, 1.0)

    def _lead(self, pose: SE2, most: float = 2.0) -> None:
        """Note how far it has come, and lead a turn on.

        From half a turn on the shorter side is the wrong one: so its end is led at `most` [rad].
        """
        leg = self._leg
        if not leg.angle:
            self.done = (self._start.inverse() @ pose).x
            return
        self.done += wrap(pose.theta - self._last.theta)
        self._last = pose
        ahead = min(max(leg.angle - self.done, -most), most)
        if leg.distance:
            now = min(max(self.done / leg.angle, 0.0), 1.0)
            self._follow(now, min(now + most / abs(leg.angle), 1.0))
        else:
            self._tracker.follow(np.array([pose.array(), (pose @ SE2(0.0, 0.0, ahead)).array()]))

    def _follow(self, begin: float, end: float, step: float = 0.02) -> None:
        """Track a part of the leg, by its shares, through poses every few centimetres [m]."""
        leg = self._leg
        shares = np.linspace(begin, end, 2 + int(abs(leg.distance) * (end - begin) / step))
        whole = np.array([leg.distance, 0.0, leg.angle])
        poses = [(self._start @ SE2.exp(share * whole)).array() for share in shares]
        if leg.angle and end == 1.0:
            poses.append(poses[-1])  # a turn to the end's heading
        self._tracker.follow(np.array(poses))
