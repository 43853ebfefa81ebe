"""The pattern that a robot drives to be calibrated, and what is measured on the way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity

_REST = 1.0  # [s] after each manoeuvre, more than twice what braking from 1 m/s takes
_QUARTER = math.pi / 2


@dataclass(frozen=True)
class Measurement:
    """What is measured at one instant.

    Attributes:
        wheels: Left and right wheels' mean angles, by the encoders [rad].
        pose: Where the robot really is.
    """

    wheels: tuple[float, float]
    pose: SE2


class Vehicle(Protocol):
    """What can be driven and observed: a simulated robot, or a real one with a tracker."""

    @property
    def tick(self) -> float:
        """How long a command is held [s]."""

    def drive(self, velocity: Velocity) -> None:
        """Hold a velocity for a tick."""

    def observe(self) -> Measurement:
        """Measure now."""


@dataclass(frozen=True)
class Manoeuvre:
    """One part of the pattern, from rest to rest.

    Attributes:
        command: What is commanded.
        seconds: For how long [s].
    """

    command: Velocity
    seconds: float

    @property
    def kind(self) -> str:
        """Whether it is a `straight`, a `spin` or an `arc`."""
        if self.command.yaw_rate == 0.0:
            return "straight"
        return "spin" if self.command.x == 0.0 else "arc"


def _turn(v: float, w: float, angle: float) -> Manoeuvre:
    return Manoeuvre(Velocity(v, yaw_rate=w), angle / abs(w))


PATTERN = (
    Manoeuvre(Velocity(0.5), 4.0),
    _turn(0.0, 1.0, _QUARTER),
    Manoeuvre(Velocity(0.3), 4.0),
    _turn(0.0, 2.0, _QUARTER),
    Manoeuvre(Velocity(1.0), 2.0),
    _turn(0.0, 0.5, math.pi),
    _turn(0.4, 0.5, math.pi),
    _turn(0.0, -1.0, _QUARTER),
    _turn(0.4, -0.5, math.pi),
    _turn(0.0, -2.0, _QUARTER),
    _turn(0.5, 1.0, math.pi),
    Manoeuvre(Velocity(-0.3), 4.0),
    _turn(0.6, -1.0, math.pi),
    _turn(0.0, -0.5, _QUARTER),
)
"""Straights, spins and arcs, slow and fast, to either side; within 4 m of the start."""


@dataclass(frozen=True)
class DriveLog:
    """What was measured while the pattern was driven.

    Attributes:
        wheels: Left and right wheels' angles after each tick, `(T, 2) float64` [rad].
        truth: True x, y [m] and unwrapped heading [rad] after each tick, `(T, 3) float64`.
        spans: Each manoeuvre with its first and last tick.
        tick: [s].
    """

    wheels: NDArray[np.float64]
    truth: NDArray[np.float64]
    spans: tuple[tuple[Manoeuvre, int, int], ...]
    tick: float

    def path(self, manoeuvre: Manoeuvre, start: int, end: int) -> float:
        """Return the true length of a manoeuvre's path, negative backward [m]."""
        steps = np.diff(self.truth[start : end + 1, :2], axis=0)
        return math.copysign(float(np.linalg.norm(steps, axis=1).sum()), manoeuvre.command.x)


def drive(vehicle: Vehicle) -> DriveLog:
    """Drive the pattern."""
    seen, spans = [vehicle.observe()], []
    for manoeuvre in PATTERN:
        start = len(seen) - 1
        moving, resting = (round(t / vehicle.tick) for t in (manoeuvre.seconds, _REST))
        for command in [manoeuvre.command] * moving + [Velocity()] * resting:
            vehicle.drive(command)
            seen.append(vehicle.observe())
        spans.append((manoeuvre, start, len(seen) - 1))
    truth = np.array([item.pose.array() for item in seen])
    truth[:, 2] = np.unwrap(truth[:, 2])
    return DriveLog(np.array([item.wheels for item in seen]), truth, tuple(spans), vehicle.tick)
