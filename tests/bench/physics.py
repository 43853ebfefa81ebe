"""A robot that stands, drives, turns and climbs: parked, on a slope, over a metre and a sill."""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.bases import base_of
from arjuna_sim.devices.driving.controller import limited
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.geometry.shapes import corners
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.world import World
from arjuna_sim.sills import crossed_sill
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROBOT
from tests.sim.generated import chassis, level, sill, slope
from tests.sim.robot_files.options import robot_files
from tests.sim.robot_files.package import write

_PARKED = 60.0  # [s]
_SLOPE = 10.0  # [deg]
_SETTLE, _REST = 1.0, 2.0  # [s]
_SPEED, _TURN = 0.3, 0.8
_BEND = 0.8  # of the sharpest bend of a robot that steers
_ERROR = 3e-3  # that what is said of sills may have [m]
_DEPTH = 1.0  # of a sill, by the wheels' radius
_KEYS = (
    "parked_mm",
    "slope_mm",
    "drive_error",
    "turn_error_deg",
    "overspeed",
    "sill_m",
    "sill_stops",
    "sill_said_m",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--robot", type=Path, default=ROBOT, help="URDF or xacro (the shipped one)")
    parser.add_argument(
        "--package-path",
        action="append",
        default=[],
        metavar="DIR",
        help="folder of ROS packages that the robot's file refers to",
    )
    parser.add_argument("--timestep", type=float, metavar="S", help="of the physics")
    parser.add_argument(
        "--generated",
        type=int,
        metavar="N",
        help="measure so many generated robots instead, half of them read from files",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure a robot on made-up ground.

    Returns:
        `parked_mm`: farthest from where it stood in 60 s on level ground, `slope_mm`: on 10
        degrees, `drive_error` of 1 m by its share, `turn_error_deg` of 90 degrees, `overspeed`:
        peak over command, `sill_m`: the highest sill that it crossed, `sill_stops`: what of it met
        the next one, `sill_said_m`: what `sim --check` says of it, `side_error` of 1 m to the left
        where wheels can; by the robots' names where they are generated.
    """
    step = arguments.timestep
    config = SimulatorConfig() if step is None else SimulatorConfig(physics_timestep=step)
    print(
        f"{'mm parked':>10}{'on 10 deg':>10}{'drive':>8}{'turn':>8}{'over':>7}"
        f"{'sill':>8}{'said':>7}"
    )
    if arguments.generated is not None:
        robots = _generated(arguments.generated)
        return {name: _measure(robot, config, name) for name, robot in robots.items()}
    robot = load_robot(arguments.robot, SearchPath.of(arguments.package_path))
    return _measure(robot, config, robot.urdf.name)


def _generated(count: int) -> dict[str, RobotModel]:
    """Return robots of all sizes, and those of files written in every form."""
    robots = {c.name: c.robot() for c in chassis(count // 2)}
    with tempfile.TemporaryDirectory() as folder:
        for i, file in enumerate(robot_files(count - count // 2)):
            robots[file.name] = load_robot(write(file, Path(folder) / str(i)))
    return robots


def _measure(robot: RobotModel, config: SimulatorConfig, name: str) -> dict[str, Any]:
    drive_error, over_straight = _drive(robot, config)
    turn_error, over_turn = _turn(robot, config)
    values = (
        _parked(robot, config, level()),
        _parked(robot, config, slope(_SLOPE)),
        drive_error,
        turn_error,
        max(over_straight, over_turn),
        *_sill(robot, config),
    )
    parked, on_slope, drive, turn, over, height, stops, said = values
    print(
        f"{parked:10.3f}{on_slope:10.3f}{100 * drive:7.2f}%{turn:8.2f}{over:7.3f}"
        f"{1e3 * height:5.0f} mm of{1e3 * said:4.0f}  {name}{stops and f' (stopped by {stops})'}",
        flush=True,
    )
    return {**dict(zip(_KEYS, values, strict=True)), "side_error": _sideways(robot, config)}


def _simulator(
    robot: RobotModel, world: World, config: SimulatorConfig, x: float = 0.0
) -> Simulation:
    return Simulation(solo(robot, SE2(x, 0.0, 0.0)), world, config, np.random.default_rng(0))


def _parked(robot: RobotModel, config: SimulatorConfig, world: World) -> float:
    """Return how far a robot without a command gets from where it came to rest [mm]."""
    sim = _simulator(robot, world, config)
    for _ in range(round(_SETTLE / config.tick)):
        sim.drive()
    start, farthest = sim.robot.truth().pose, 0.0
    for _ in range(round((_PARKED - _SETTLE) / config.tick)):
        farthest = max(farthest, start.distance(sim.drive().truth.pose))
    return 1e3 * farthest


def _drive(robot: RobotModel, config: SimulatorConfig) -> tuple[float, float]:
    """Drive for 1 m and stop; return the path's error and the peak speed, by what was asked."""
    sim = _simulator(robot, level(), config)
    speed = min(_SPEED, limited(config.drive, robot.drive).forward.value)
    peak = _follow(sim, Velocity(speed), 1.0 / speed, lambda truth: truth.v)
    return math.hypot(sim.robot.truth().pose.x, sim.robot.truth().pose.y) - 1.0, peak / speed


def _sideways(robot: RobotModel, config: SimulatorConfig) -> float | None:
    """Drive 1 m to the left; return the path's error by its share, None where wheels cannot."""
    if not robot.drive.grips:
        return None
    sim = _simulator(robot, level(), config)
    speed = min(_SPEED, limited(config.drive, robot.drive).forward.value)
    _follow(sim, Velocity(y=speed), 1.0 / speed, lambda truth: truth.side)
    return math.hypot(sim.robot.truth().pose.x, sim.robot.truth().pose.y - 1.0)


def _turn(robot: RobotModel, config: SimulatorConfig) -> tuple[float, float]:
    """Turn by 90 degrees, on the spot unless it steers.

    Returns:
        The error [deg] and the peak rate by the asked one.
    """
    sim = _simulator(robot, level(), config)
    limits = limited(config.drive, robot.drive)
    command = Velocity(yaw_rate=min(_TURN, limits.turn.value))
    if robot.drive.kind is DriveKind.STEERED:
        base, speed = base_of(robot, config.drive), min(_SPEED, limits.forward.value)
        turned = base.reachable(Velocity(speed, yaw_rate=command.yaw_rate))
        command = Velocity(speed, yaw_rate=_BEND * turned.yaw_rate)
        creep = 0.01  # at which it steers first: a heavy wheel takes its time
        for _ in range(round(2.0 * _SETTLE / config.tick)):
            sim.drive(Velocity(creep * speed, yaw_rate=creep * command.yaw_rate))
    rate = command.yaw_rate
    peak = _follow(sim, command, math.pi / 2 / rate, lambda truth: truth.w)
    return math.degrees(wrap(sim.robot.truth().pose.theta - math.pi / 2)), peak / rate


def _follow(sim: Simulation, command: Velocity, seconds: float, speed: Any) -> float:
    """Hold a command for a time, then stop; return the peak speed."""
    peak = 0.0
    for now, count in ((command, seconds), (Velocity(), _REST)):
        for _ in range(round(count / sim.config.tick)):
            peak = max(peak, abs(speed(sim.drive(now).truth)))
    return peak


def _sill(robot: RobotModel, config: SimulatorConfig) -> tuple[float, str, float]:
    """Return the highest sill that the robot crosses [m], what the next one stops, and what is
    said.

    They are 3 mm apart: what is said holds if it is between the two.
    """
    said = crossed_sill(robot, level(), config)
    if said is None:
        return 0.0, "", 0.0
    highest = 0.0
    for height in (said.height - _ERROR, said.height + _ERROR):
        stops = _stops_at(robot, config, height) if height > 0.0 else None
        if stops is not None:
            return highest, stops, said.height
        highest = max(height, 0.0)
    return highest, "", said.height


def _stops_at(robot: RobotModel, config: SimulatorConfig, height: float) -> str | None:
    """Return the links that a sill stops; None where the robot crosses it upright."""
    reach, depth = _reach(robot), _DEPTH * robot.drive.radius
    edge, goal = 2.0 * reach, 4.0 * reach + depth
    sim = _simulator(robot, sill(height, edge, depth), config)
    command = Velocity(min(_SPEED, limited(config.drive, robot.drive).forward.value))
    for _ in range(round((2.0 * goal / command.x + 2.0) / config.tick)):
        truth = sim.drive(command).truth
        if truth.pose.x > goal:
            upright = max(abs(truth.roll), abs(truth.pitch)) < 1.0
            return None if upright else "a fall"
    scene, pairs = sim.stage.scene, sim.stage.data.contact.geom
    met = [geom for pair in pairs if scene.is_obstacle[pair].any() for geom in pair]
    names = {scene.model.geom(int(geom)).name.rpartition("//")[0] for geom in met}
    return ", ".join(sorted(names - {""})) or "nothing: it has no grip"


def _reach(robot: RobotModel) -> float:
    """Return how far the robot reaches from its root, seen from above [m]."""
    points = [
        (robot.urdf.T_root(link.name) @ part.pose).apply(corners(part.shape))[:, :2]
        for link in robot.urdf.links.values()
        for part in link.collisions
    ]
    return float(np.linalg.norm(np.vstack(points), axis=1).max())
