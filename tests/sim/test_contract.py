"""Every robot and every world that ships: loads, drives and repeats itself byte for byte."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROOT

ROBOTS = sorted(path for path in (ROOT / "urdf").iterdir() if path.suffix in (".urdf", ".xacro"))
WORLDS = sorted(
    path
    for folder in ("worlds", "maps")
    for path in (ROOT / folder).iterdir()
    if path.suffix in (".world", ".sdf", ".yaml")
)
PAIRS = [
    (robot, world)
    for i, robot in enumerate(ROBOTS)
    for k, world in enumerate(WORLDS)
    if (i - k) % 3 == 0 or k == 0
]
"""Each robot in some of the worlds, each world with some of the robots."""


_robot, _world = cache(load_robot), cache(load_world)  # plain values; xacro takes most of the time


def _drive(robot: Path, world: Path, seed: int) -> tuple[bytes, float, bool]:
    """Drive for 2 s; return all that was sensed, how far the robot came [m], and if noise came."""
    rng = np.random.default_rng(seed)
    start = SE2(-2.0, -0.5) if world.stem == "pillar_arena" else SE2()  # a pillar is at its origin
    sim = Simulation(solo(_robot(robot), start), _world(world), SimulatorConfig(), rng)
    assert sim.robot.obstacles_at(sim.robot.spawn) == ()
    parts, is_noisy = [], False
    for _ in range(round(2.0 / sim.config.tick)):
        seen = sim.drive(Velocity(0.2, yaw_rate=0.4))
        numbers = [*seen.odometry.T_odom_base.array(), *seen.truth.pose.array(), seen.truth.z]
        assert all(math.isfinite(number) for number in numbers)
        parts += [np.array(numbers), seen.joints.positions, seen.joints.velocities]
        if seen.imu is not None:
            parts += [seen.imu.angular_velocity, seen.imu.linear_acceleration]
            is_noisy = True
        if seen.scan is not None:
            parts.append(seen.scan.ranges)
            is_noisy = is_noisy or bool(np.isfinite(seen.scan.ranges).any())
    assert np.isfinite(np.concatenate(parts[1::3])).any()
    sensed = b"".join(part.tobytes() for part in parts)
    return sensed, sim.robot.spawn.distance(seen.truth.pose), is_noisy


@pytest.mark.parametrize(("robot", "world"), PAIRS, ids=lambda path: path.name)
def test_robot_drives_in_world_and_each_repeats_itself(robot: Path, world: Path) -> None:
    sensed, path, is_noisy = _drive(robot, world, 5)
    assert 0.25 < path < 0.45
    if world == WORLDS[0] or robot == next(one for one, other in PAIRS if other == world):
        assert sensed == _drive(robot, world, 5)[0]
    if world == WORLDS[0]:  # each robot is in it
        assert (sensed != _drive(robot, world, 6)[0]) == is_noisy
