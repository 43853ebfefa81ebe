"""Finding the effective track width and wheel radius of a robot by driving a set pattern."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import wrap
from arjuna_sim.devices.drive import Kinematics, Velocity
from arjuna_sim.devices.odometry import Odometry, OdometryConfig
from arjuna_sim.simulator import Simulator, SimulatorConfig

_REST = 1.0  # [s] after each manoeuvre
_QUARTER = math.pi / 2
_LEAST_NOISE = 1e-3


class CalibrationError(ArjunaError):
    """The robot cannot drive the pattern."""


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
        if self.command.w == 0.0:
            return "straight"
        return "spin" if self.command.v == 0.0 else "arc"


def _turn(v: float, w: float, angle: float) -> Manoeuvre:
    return Manoeuvre(Velocity(v, w), angle / abs(w))


PATTERN = (
    Manoeuvre(Velocity(0.5, 0.0), 4.0),
    _turn(0.0, 1.0, _QUARTER),
    Manoeuvre(Velocity(0.3, 0.0), 4.0),
    _turn(0.0, 2.0, _QUARTER),
    Manoeuvre(Velocity(1.0, 0.0), 2.0),
    _turn(0.0, 0.5, math.pi),
    _turn(0.4, 0.5, math.pi),
    _turn(0.0, -1.0, _QUARTER),
    _turn(0.4, -0.5, math.pi),
    _turn(0.0, -2.0, _QUARTER),
    _turn(0.5, 1.0, math.pi),
    Manoeuvre(Velocity(-0.3, 0.0), 4.0),
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
    """What calibration found.

    Attributes:
        nominal: The kinematics that the wheels' separation and radius suggest.
        found: The effective ones.
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


def calibrate(
    robot_path: str | Path, world_path: str | Path, config: SimulatorConfig
) -> Calibration:
    """Identify the ideal two-wheeled robot that moves as this one does.

    The pattern is driven twice: to identify, then to check. Only encoders and truth are used.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007.

    Args:
        robot_path: A URDF file.
        world_path: A world with 4 m of free space around its origin.
        config: Physics; its own calibration does not matter.

    Returns:
        Effective track width and radius, and how well they do.

    Raises:
        CalibrationError: The robot has no wheels, does not move, or bumps into something.
        RobotError: The robot cannot be simulated.
        WorldError: The world cannot be simulated.
    """
    nominal = _nominal(Simulator(robot_path, world_path, config, np.random.default_rng(0)))
    found = identify(drive(robot_path, world_path, _with(config, nominal)))
    check = drive(robot_path, world_path, _with(config, found))
    after = compare(check, found)
    noise = _noise(config.odometry, after)
    return Calibration(nominal, found, check, compare(check, nominal), after, noise)


def _nominal(simulator: Simulator) -> Kinematics:
    settings = simulator.robot.drive
    if not settings.left or not settings.right:
        raise CalibrationError(f"{simulator.robot.urdf.path}: has no wheels to calibrate")
    return Kinematics(settings.separation, settings.radius)


def _with(config: SimulatorConfig, kinematics: Kinematics) -> SimulatorConfig:
    calibrated = replace(
        config.drive,
        effective_track_width=kinematics.track,
        effective_wheel_radius=kinematics.radius,
    )
    return replace(config, drive=calibrated)


def drive(robot_path: str | Path, world_path: str | Path, config: SimulatorConfig) -> DriveLog:
    """Drive the pattern.

    Raises:
        CalibrationError: The robot bumps into something.
    """
    simulator = Simulator(robot_path, world_path, config, np.random.default_rng(0))
    wheels, truth, spans = [simulator.wheel_angles()], [_place(simulator)], []
    for manoeuvre in PATTERN:
        start = len(truth) - 1
        moving = round(manoeuvre.seconds / config.tick)
        for i in range(moving + round(_REST / config.tick)):
            touched = simulator.step(manoeuvre.command if i < moving else Velocity()).contacts
            if touched:
                problem = f"bumped into {touched[0]}; valid: a world with 4 m of free space"
                raise CalibrationError(f"{world_path}: the robot {problem}")
            wheels.append(simulator.wheel_angles())
            truth.append(_place(simulator))
        spans.append((manoeuvre, start, len(truth) - 1))
    places = np.array(truth)
    places[:, 2] = np.unwrap(places[:, 2])
    return DriveLog(np.array(wheels), places, tuple(spans), config.tick)


def _place(simulator: Simulator) -> tuple[float, float, float]:
    pose = simulator.truth().pose
    return pose.x, pose.y, pose.theta


def identify(log: DriveLog) -> Kinematics:
    """Fit the radius to the straights and the track to all turns, by least squares.

    Raises:
        CalibrationError: The wheels turned, but the robot did not follow.
    """
    rolled, path, across, turn = 0.0, 0.0, [], []
    for manoeuvre, start, end in log.spans:
        left, right = (log.wheels[end] - log.wheels[start]).tolist()
        if manoeuvre.kind == "straight":
            rolled, path = rolled + (left + right) / 2, path + _path(log, manoeuvre, start, end)
        else:
            across.append(right - left)
            turn.append(log.truth[end, 2] - log.truth[start, 2])
    radius = path / rolled if rolled else 0.0
    ratio = float(np.dot(across, turn) / max(np.dot(across, across), 1e-12))
    if not (radius > 0.0 and ratio > 0.0):
        raise CalibrationError("the wheels turn, but the robot does not follow them")
    return Kinematics(radius / ratio, radius)


def _path(log: DriveLog, manoeuvre: Manoeuvre, start: int, end: int) -> float:
    """Return the true length of a path, negative backward [m]."""
    steps = np.diff(log.truth[start : end + 1, :2], axis=0)
    return math.copysign(float(np.linalg.norm(steps, axis=1).sum()), manoeuvre.command.v)


def dead_reckon(log: DriveLog, kinematics: Kinematics) -> NDArray[np.float64]:
    """Return the path that odometry makes of the encoders, `(T, 3) float64`, from the true start.

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
        rows.append(Comparison(manoeuvre, path, _path(log, manoeuvre, start, end), turn, true_turn))
    return tuple(rows)


def _noise(config: OdometryConfig, rows: tuple[Comparison, ...]) -> OdometryConfig:
    """Return standard deviations per root of path and turn that the errors have."""

    def fit(values: list[float]) -> float:
        return max(_LEAST_NOISE, math.sqrt(sum(values) / max(1, len(values))))

    straight = [row for row in rows if row.manoeuvre.kind == "straight"]
    spins = [row for row in rows if row.manoeuvre.kind == "spin"]
    return replace(
        config,
        linear_noise=fit([(r.path - r.true_path) ** 2 / abs(r.true_path) for r in straight]),
        angular_noise=fit([wrap(r.turn - r.true_turn) ** 2 / abs(r.true_turn) for r in spins]),
        drift_noise=fit([wrap(r.turn - r.true_turn) ** 2 / abs(r.true_path) for r in straight]),
    )
