"""Odometry over a square of 20 m: by the wheels as the file has them, calibrated, and fused."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.calibrate import SimulatedVehicle
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.calibration import calibrate
from arjuna_sim.devices.drive import Kinematics
from arjuna_sim.devices.driving.bases import base_of
from arjuna_sim.devices.driving.controller import limited
from arjuna_sim.devices.ekf import FusedOdometry, FusedOdometryConfig
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.driven_robot import Observation
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROBOT
from tests.sim.generated import level

_EDGE = 5.0  # of the square [m]
_SPEED, _TURN = 0.4, 0.8
_BEND = 0.8  # of the sharpest bend of a robot that steers
_REST = 1.0  # at each corner [s]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--robot", type=Path, nargs="+", default=[ROBOT], help="URDF or xacro (the shipped one)"
    )
    parser.add_argument(
        "--package-path",
        action="append",
        default=[],
        metavar="DIR",
        help="folder of ROS packages that the robot's file refers to",
    )
    parser.add_argument("--seeds", type=int, default=3, help="squares (%(default)s)")
    parser.add_argument(
        "--sideways", action="store_true", help="go along the edges without turning"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive each robot around a square on level ground, resting at its corners.

    Returns:
        By robot the worst of its squares: of `nominal`, `calibrated` and `fused` odometry the error
        of the position at the end, per distance driven, and of the heading [deg]; fused is None
        without an IMU.
    """
    path = SearchPath.of(arguments.package_path)
    found = {}
    for file in arguments.robot:
        robot = load_robot(file, path)
        config = _calibrated(robot)
        nominal = _worst(robot, SimulatorConfig(), arguments)
        found[robot.urdf.name] = {
            "nominal": nominal["wheels"],
            "calibrated": (calibrated := _worst(robot, config, arguments))["wheels"],
            "fused": calibrated.get("fused"),
        }
        shown = "  ".join(
            f"{kind} {100 * error[0]:.2f} % {error[1]:.2f} deg"
            for kind, error in found[robot.urdf.name].items()
            if error is not None
        )
        print(f"{robot.urdf.name:24} {shown}", flush=True)
    return found


def _calibrated(robot: RobotModel) -> SimulatorConfig:
    """Return a configuration with what calibration finds, as far as the drive can be."""
    drive, config = robot.drive, SimulatorConfig()
    if drive.kind is not DriveKind.SIDES:
        return config
    nominal, world = Kinematics(drive.separation, drive.radius), level()
    kinematics = calibrate(
        lambda kinematics: SimulatedVehicle(robot, world, config, kinematics),
        nominal,
        config.odometry,
    ).found
    known = replace(
        config.drive,
        effective_track_width=kinematics.track,
        effective_wheel_radius=kinematics.radius,
    )
    return replace(config, drive=known)


def _worst(
    robot: RobotModel, config: SimulatorConfig, arguments: argparse.Namespace
) -> dict[str, tuple[float, float]]:
    """Return the greatest errors of several squares by what measures them."""
    runs = [_square(robot, config, seed, arguments.sideways) for seed in range(arguments.seeds)]
    return {
        kind: (max(run[kind][0] for run in runs), max(run[kind][1] for run in runs))
        for kind in runs[0]
    }


def _square(
    robot: RobotModel, config: SimulatorConfig, seed: int, sideways: bool
) -> dict[str, tuple[float, float]]:
    """Return the errors per distance driven, and of the heading [deg], at a square's end."""
    sim = Simulation(solo(robot), level(), config, np.random.default_rng(seed))
    filter_ = FusedOdometry(FusedOdometryConfig())
    start = sim.robot.truth().pose
    driven = 0.0
    for command, seconds in _legs(robot, config, sideways):
        for _ in range(round(seconds / config.tick)):
            before = sim.robot.truth().pose
            seen = sim.drive(command)
            driven += before.distance(seen.truth.pose)
            _fuse(filter_, seen, config.tick)
    truth = start.inverse() @ seen.truth.pose
    errors = {"wheels": _error(seen.odometry.T_odom_base, truth, driven)}
    if robot.settings.first(ImuSettings) is not None:
        errors["fused"] = _error(filter_.estimate.T_odom_base, truth, driven)
    return errors


def _legs(
    robot: RobotModel, config: SimulatorConfig, sideways: bool
) -> Iterator[tuple[Velocity, float]]:
    limits, stop = limited(config.drive, robot.drive), (Velocity(), _REST)
    speed = min(_SPEED, limits.forward.value)
    turn = Velocity(yaw_rate=min(_TURN, limits.turn.value))
    if robot.drive.kind is DriveKind.STEERED:
        bend = base_of(robot, config.drive).reachable(Velocity(speed, yaw_rate=turn.yaw_rate))
        turn = Velocity(speed, yaw_rate=_BEND * bend.yaw_rate)
    yield stop
    for k in range(4):
        along = (round(math.cos(k * math.pi / 2)), round(math.sin(k * math.pi / 2)))
        v, side = along if sideways else (1, 0)
        yield Velocity(speed * v, y=speed * side), _EDGE / speed
        yield stop
        if not sideways:
            yield turn, math.pi / 2 / turn.yaw_rate
            yield stop


def _fuse(filter_: FusedOdometry, seen: Observation, dt: float) -> None:
    """Feed the filter as the node ekf_filter_node does."""
    filter_.predict(dt)
    filter_.wheels(seen.odometry.v, seen.odometry.w, seen.odometry.side)
    if seen.imu is not None:
        up = seen.imu.orientation.rotation()[2]
        filter_.gyro(float(up @ seen.imu.angular_velocity), seen.imu.angular_variance)


def _error(estimate: SE2, truth: SE2, driven: float) -> tuple[float, float]:
    off = abs(math.degrees(wrap(estimate.theta - truth.theta)))
    return estimate.distance(truth) / driven, off
