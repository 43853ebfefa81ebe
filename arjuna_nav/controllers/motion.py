"""Laws of motion that all controllers share: arcs, braking and turning on the spot."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.config import length_param, param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity


def gentle_turns() -> Any:
    """Declare the parameter of the controllers that turn on the spot."""
    text = (
        "Whether turns on the spot brake early, and pure pursuit's end early, bend where there is"
        " room and bound the yaw rate of bends too; as Nav2 they are as fast as can be braked."
    )
    return param(True, text, theirs=False)


def min_turning_radius(use: str = "") -> Any:
    """Declare the parameter of the servers whose robot may be steered."""
    text = f"Radius of the robot's tightest bend, as its file says{use}; 0: it turns on the spot."
    return length_param(0.0, text, maximum=100.0)


def rollout(
    pose: SE2,
    velocity: Velocity,
    duration: float,
    spacing: float,
    turn_step: float = 0.1,
    limit: int = 10_000,
) -> Floats:
    """Return the poses along the arc that a constant velocity drives, one round of it at most.

    Args:
        duration: For how long [s].
        spacing: Greatest distance between two poses [m].
        turn_step: Greatest angle between two; 0.1 moves a corner 0.5 m out by a cell [rad].
        limit: Greatest number of poses.

    Returns:
        `(N, 3) float64` [m, m, rad], the start first.
    """
    duration = min(duration, 2.0 * math.pi / max(abs(velocity.yaw_rate), 1e-9))
    travel, turn = velocity.speed * duration, abs(velocity.yaw_rate) * duration
    count = 1 + math.ceil(min(max(travel / spacing, turn / turn_step), limit))
    start = float(pose.x), float(pose.y), float(pose.theta)
    motion = float(velocity.x), float(velocity.y), float(velocity.yaw_rate)
    poses: Floats = _arc(start, motion, float(duration), count)
    return poses


@njit(cache=True)
def _arc(
    start: tuple[float, float, float],
    motion: tuple[float, float, float],
    duration: float,
    count: int,
) -> Floats:
    """Return poses evenly in time along an arc, its ends among them."""
    x, y, theta = start
    v, side, w = motion
    poses = np.empty((count, 3))
    for k in range(count):
        time = duration * k / max(count - 1, 1)
        half = 0.5 * w * time
        chord = time * (math.sin(half) / half if half != 0.0 else 1.0)
        along, left = chord * math.cos(theta + half), chord * math.sin(theta + half)
        poses[k, 0] = x + v * along - side * left
        poses[k, 1] = y + v * left + side * along
        poses[k, 2] = theta + 2.0 * half
    return poses


def steered(velocity: Velocity, radius: float) -> Velocity:
    """Return a velocity whose arc is no tighter than a radius [m]; 0 is none."""
    if radius <= 0.0 or abs(velocity.yaw_rate) * radius <= abs(velocity.x):
        return velocity
    return replace(velocity, yaw_rate=math.copysign(abs(velocity.x) / radius, velocity.yaw_rate))


def crossing(pose: SE2, before: SE2, after: SE2, distance: float) -> float:
    """Return where a segment leaves the circle of a radius round the robot, as a ratio 0..1."""
    dx, dy = after.x - before.x, after.y - before.y
    fx, fy = before.x - pose.x, before.y - pose.y
    a, b, c = dx * dx + dy * dy, fx * dx + fy * dy, fx * fx + fy * fy - distance * distance
    if a == 0.0:
        return 1.0
    root = math.sqrt(max(b * b - a * c, 0.0))
    return min(max((root - b) / a, 0.0), 1.0)


@njit(cache=True)
def curvature_to(x: float, y: float) -> float:
    """Return the curvature [1/m] of the arc to a point seen from the robot [m].

    Source: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.
    """
    return 2.0 * y / max(x * x + y * y, 1e-6)


def curvature_into(seen: SE2) -> float:
    """Return the curvature [1/m] with which a curve to a pose begins, seen from the robot.

    The curve is a cubic, which ends with the pose's heading; on a circle it is the arc's.
    """
    bearing, distance = math.atan2(seen.y, seen.x), math.hypot(seen.x, seen.y)
    return (4.0 * math.sin(bearing) - 2.0 * math.sin(seen.theta - bearing)) / max(distance, 1e-3)


@njit(cache=True)
def braking_speed(distance: float, deceleration: float, final: float) -> float:
    """Return the speed from which one brakes to a final speed within a distance.

    It holds for yaw rates and angles, too.
    """
    return math.sqrt(final * final + 2.0 * deceleration * max(distance, 0.0))


@njit(cache=True)
def braking_distance(speed: float, deceleration: float) -> float:
    """Return the distance within which one brakes from a speed to rest."""
    return speed * speed / (2.0 * deceleration)


class MotionLimits(NamedTuple):
    """Limits of turning, speeding up and slowing down, from a controller's parameters.

    Attributes:
        yaw_rate: Greatest on the spot [rad/s].
        acceleration: 0 where none is given [m/s^2].
        deceleration: The same, above 0 [m/s^2].
        angular_acceleration: 0 where none is given [rad/s^2].
        angular_deceleration: The same, above 0 [rad/s^2].
    """

    yaw_rate: float = math.inf
    acceleration: float = 0.0
    deceleration: float = 0.0
    angular_acceleration: float = 0.0
    angular_deceleration: float = 0.0

    def eased(self, command: Velocity, *reached: Velocity, period: float) -> Velocity:
        """Return what of a command can be driven a period [s] after velocities, on its arc.

        It slows down at once: how early it brakes is planned before.
        """
        x = _risen(command.x, [one.x for one in reached], self.acceleration * period)
        w = command.yaw_rate * (x / command.x if command.x else 1.0)
        rates = [one.yaw_rate for one in reached]
        return replace(command, x=x, yaw_rate=_risen(w, rates, self.angular_acceleration * period))


def _risen(value: float, reached: list[float], step: float) -> float:
    """Return the value, no more than a step, if any, beyond the farthest reached on its side."""
    farthest = max(0.0, *(one * math.copysign(1.0, value) for one in reached))
    return math.copysign(min(abs(value), farthest + (step or math.inf)), value)


@dataclass(frozen=True)
class Turning:
    """Limits of a turn on the spot.

    Attributes:
        rate: Greatest yaw rate [rad/s].
        acceleration: Greatest change of the yaw rate [rad/s^2].
        period: Time between two commands [s].
        gain: Yaw rate per angle left [1/s].
        rate_min: Yaw rate below which the wheels stick [rad/s].
        settled: Angle left below which the wheels may stick [rad].
        gentle: Whether it brakes early and by the gain.
    """

    rate: float
    acceleration: float
    period: float
    gain: float = 1.5
    rate_min: float = 0.1
    settled: float = 0.05
    gentle: bool = True

    def towards(self, angle: float, last: float) -> float:
        """Return the yaw rate that turns by an angle and comes to rest there [rad/s].

        Args:
            angle: Left to turn [rad].
            last: Yaw rate commanded last, or measured [rad/s].
        """
        change = self.acceleration * self.period
        if not self.gentle:  # nav2_regulated_pure_pursuit_controller, rotateToHeading
            rate = min(max(math.copysign(self.rate, angle), last - change), last + change)
            most = braking_speed(abs(angle), self.acceleration, 0.0)
            return rate if abs(rate) <= most else math.copysign(most, angle)
        brake = braking_speed(abs(angle), 0.5 * self.acceleration, 0.0)  # half: none overshoots
        rate = min(self.rate, brake, self.gain * abs(angle))
        if abs(angle) > self.settled:
            rate = max(rate, min(self.rate_min, self.rate))
        return min(max(math.copysign(rate, angle), last - change), last + change)
