"""The effective track width and wheel radius of a robot, from driving a set pattern."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import Kinematics
from arjuna_sim.devices.odometry import Odometry, OdometryConfig


@dataclass(frozen=True)
class Measurement:
    """A measurement at one instant.

    Attributes:
        wheels: Left and right wheels' mean angles, by the encoders [rad].
        pose: Where the robot really is.
    """

    wheels: tuple[float, float]
    pose: SE2


class Vehicle(Protocol):
    """A vehicle to drive and observe: a simulated robot, or a real one with a tracker."""

    @property
    def tick(self) -> float:
        """The time for which a command is held [s]."""

    def drive(self, velocity: Velocity) -> None:
        """Hold a velocity for a tick."""

    def observe(self) -> Measurement:
        """Measure now."""


@dataclass(frozen=True)
class Manoeuvre:
    """One part of the pattern, from rest to rest.

    Attributes:
        seconds: For how long [s].
    """

    command: Velocity
    seconds: float

    @property
    def kind(self) -> str:
        """The kind: `straight`, `spin` or `arc`."""
        if self.command.yaw_rate == 0.0:
            return "straight"
        return "spin" if self.command.x == 0.0 else "arc"


def _turn(v: float, w: float, angle: float = math.pi / 2) -> Manoeuvre:
    return Manoeuvre(Velocity(v, yaw_rate=w), angle / abs(w))


PATTERN = (
    Manoeuvre(Velocity(0.5), 4.0),
    _turn(0.0, 1.0),
    Manoeuvre(Velocity(0.3), 4.0),
    _turn(0.0, 2.0),
    Manoeuvre(Velocity(1.0), 2.0),
    _turn(0.0, 0.5, math.pi),
    _turn(0.4, 0.5, math.pi),
    _turn(0.0, -1.0),
    _turn(0.4, -0.5, math.pi),
    _turn(0.0, -2.0),
    _turn(0.5, 1.0, math.pi),
    Manoeuvre(Velocity(-0.3), 4.0),
    _turn(0.6, -1.0, math.pi),
    _turn(0.0, -0.5),
)
"""Straights, spins and arcs, slow and fast, to either side; within 4 m of the start."""


@dataclass(frozen=True)
class DriveLog:
    """The measurements along the pattern.

    Attributes:
        wheels: Left and right wheels' angles after each tick, `(T, 2) float64` [rad].
        truth: True x, y [m] and unwrapped heading [rad] after each tick, `(T, 3) float64`.
        spans: Each manoeuvre with its first and last tick.
        tick: [s].
    """

    wheels: Floats
    truth: Floats
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
        # A rest of 1 s is more than twice what braking from 1 m/s takes.
        moving, resting = (round(t / vehicle.tick) for t in (manoeuvre.seconds, 1.0))
        for command in [manoeuvre.command] * moving + [Velocity()] * resting:
            vehicle.drive(command)
            seen.append(vehicle.observe())
        spans.append((manoeuvre, start, len(seen) - 1))
    truth = np.array([item.pose.array() for item in seen])
    truth[:, 2] = np.unwrap(truth[:, 2])
    return DriveLog(np.array([item.wheels for item in seen]), truth, tuple(spans), vehicle.tick)


class CalibrationError(ArjunaError):
    """The robot cannot drive the pattern."""


@dataclass(frozen=True)
class Comparison:
    """One manoeuvre by odometry and in truth: path [m] and turn [rad], both signed."""

    manoeuvre: Manoeuvre
    path: float
    true_path: float
    turn: float
    true_turn: float

    @property
    def path_error(self) -> float:
        """Relative error of the path; 0 of a spin, which has none."""
        return 0.0 if self.manoeuvre.kind == "spin" else self.path / self.true_path - 1.0

    @property
    def turn_error(self) -> float:
        """Relative error of the turn; 0 of a straight, which has none."""
        return 0.0 if self.manoeuvre.kind == "straight" else self.turn / self.true_turn - 1.0


@dataclass(frozen=True)
class Calibration:
    """The result of calibration.

    Attributes:
        nominal: The kinematics that the wheels' separation and radius suggest.
        check: A second drive of the pattern, under the effective ones.
        before: The second drive by the nominal kinematics.
        after: The second drive by the effective kinematics.
        noise: Odometry's noise that covers the errors that remain.
    """

    nominal: Kinematics
    found: Kinematics
    check: DriveLog
    before: tuple[Comparison, ...]
    after: tuple[Comparison, ...]
    noise: OdometryConfig

    @property
    def path_before(self) -> Floats:
        """The second drive as the nominal kinematics reckon it, `(T, 3) float64`."""
        return dead_reckon(self.check, self.nominal)

    @property
    def path_after(self) -> Floats:
        """The second drive as the effective kinematics reckon it, `(T, 3) float64`."""
        return dead_reckon(self.check, self.found)


def calibrate(
    vehicle_of: Callable[[Kinematics], Vehicle], nominal: Kinematics, config: OdometryConfig
) -> Calibration:
    """Identify the ideal two-wheeled robot that moves as this one does.

    The pattern is driven twice: to identify, then to check. Only encoders and truth are used.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007.

    Args:
        vehicle_of: Returns the robot, with 4 m of free space around it, which takes velocities for
            wheel speeds by the kinematics given.
        nominal: What the wheels' separation and radius suggest.

    Raises:
        CalibrationError: The robot does not move.
    """
    found = identify(drive(vehicle_of(nominal)))
    check = drive(vehicle_of(found))
    after = compare(check, found)
    return Calibration(nominal, found, check, compare(check, nominal), after, _noise(config, after))


def identify(log: DriveLog) -> Kinematics:
    """Fit the radius to the straights and the track to all turns, by least squares.

    Raises:
        CalibrationError: The wheels turned, but the robot did not follow.
    """
    rolled, path, across, turn = 0.0, 0.0, [], []
    for manoeuvre, start, end in log.spans:
        left, right = (log.wheels[end] - log.wheels[start]).tolist()
        if manoeuvre.kind == "straight":
            rolled, path = rolled + (left + right) / 2, path + log.path(manoeuvre, start, end)
        else:
            across.append(right - left)
            turn.append(log.truth[end, 2] - log.truth[start, 2])
    radius = path / rolled if rolled else 0.0
    ratio = float(np.dot(across, turn) / max(np.dot(across, across), 1e-12))
    if not (radius > 0.0 and ratio > 0.0):
        raise CalibrationError("the wheels turn, but the robot does not follow them")
    return Kinematics(radius / ratio, radius)


def dead_reckon(log: DriveLog, kinematics: Kinematics) -> Floats:
    """Return the path that odometry makes of the encoders, `(T, 3) float64`, from the origin.

    Headings are wrapped.
    """
    odometry = Odometry(OdometryConfig(), kinematics, np.random.default_rng(0))
    left, right = log.wheels[0].tolist()
    odometry.reset((left, right))
    poses = [odometry.update((a, b), log.tick).T_odom_base.array() for a, b in log.wheels.tolist()]
    return np.array(poses)


def compare(log: DriveLog, kinematics: Kinematics) -> tuple[Comparison, ...]:
    """Compare each manoeuvre by encoders with the truth."""
    rows = []
    for manoeuvre, start, end in log.spans:
        left, right = (log.wheels[end] - log.wheels[start]).tolist()
        path, turn = kinematics.base_motion(left, right)
        true_turn = float(log.truth[end, 2] - log.truth[start, 2])
        rows.append(Comparison(manoeuvre, path, log.path(manoeuvre, start, end), turn, true_turn))
    return tuple(rows)


def _noise(config: OdometryConfig, rows: tuple[Comparison, ...]) -> OdometryConfig:
    """Return standard deviations per root of path and turn that the errors have."""

    def fit(values: list[float]) -> float:
        # So short a pattern cannot distinguish smaller errors from chance.
        return max(1e-3, math.sqrt(sum(values) / max(1, len(values))))

    straight = [row for row in rows if row.manoeuvre.kind == "straight"]
    spins = [row for row in rows if row.manoeuvre.kind == "spin"]
    return replace(
        config,
        linear_noise=fit([(r.path - r.true_path) ** 2 / abs(r.true_path) for r in straight]),
        angular_noise=fit([wrap(r.turn - r.true_turn) ** 2 / abs(r.true_turn) for r in spins]),
        drift_noise=fit([wrap(r.turn - r.true_turn) ** 2 / abs(r.true_path) for r in straight]),
    )
