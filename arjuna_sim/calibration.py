"""Finding the effective track width and wheel radius of a skid-steer robot by driving it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from arjuna_core.se2 import wrap
from arjuna_sim.drive import Kinematics, Velocity
from arjuna_sim.simulator import Simulator, SimulatorConfig

_SETTLE, _MEASURE = 2.0, 8.0  # [s]
_SPEEDS = (0.3, 0.6, 1.0)
_TURNS = (-1.0, -0.5, 0.5, 1.0)


def calibrate(
    robot_path: str | Path, world_path: str | Path, config: SimulatorConfig
) -> Kinematics:
    """Identify the ideal two-wheeled robot that moves as this one does.

    It drives straight at three speeds (radius = path / wheel turn) and spins at four rates
    (track = difference of the wheels' paths / turn), and averages.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007.

    Args:
        robot_path: A URDF file.
        world_path: A world with 10 m of free space around its origin.
        config: Physics; its own calibration does not matter.

    Returns:
        Effective track width and radius.

    Raises:
        RobotError: The robot cannot be simulated.
        WorldError: The world cannot be simulated.
    """
    simulator = Simulator(robot_path, world_path, config, np.random.default_rng(0))
    radii = []
    for speed in _SPEEDS:
        left, right, path, _ = _drive(simulator, Velocity(speed, 0.0))
        radii.append(path / ((left + right) / 2))
    radius = sum(radii) / len(radii)
    tracks = []
    for rate in _TURNS:
        left, right, _, turn = _drive(simulator, Velocity(0.0, rate))
        tracks.append((right - left) * radius / turn)
    return Kinematics(sum(tracks) / len(tracks), radius)


def _drive(simulator: Simulator, command: Velocity) -> tuple[float, float, float, float]:
    """Drive and return the left and right wheels' turns, the path and the turn while steady."""
    tick = simulator.config.tick
    simulator.reset()
    for _ in range(round(_SETTLE / tick)):
        before = simulator.step(command)
    start, path, turn, pose = simulator.wheel_angles(), 0.0, 0.0, before.truth.pose
    for _ in range(round(_MEASURE / tick)):
        now = simulator.step(command).truth.pose
        path += math.copysign(pose.distance(now), command.v)
        turn += wrap(now.theta - pose.theta)
        pose = now
    end = simulator.wheel_angles()
    return end[0] - start[0], end[1] - start[1], path, turn
