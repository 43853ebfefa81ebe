"""Claims: a batch's drives do for each robot, to rounding, what the robot's own do."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.batch.drive import BatchDrive
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.bases import WheelSpeeds, base_of
from arjuna_sim.devices.driving.controller import CommandError, Drive, limited
from arjuna_sim.devices.odometry import Odometry
from arjuna_sim.files.robots.robot_file import load_robot
from tests.sim.builders import ROOT

CONFIG = SimulatorConfig()
ROBOTS = ("urdf/arjuna.urdf", "urdf/burger.urdf", "urdf/udacity_bot.xacro")
TICK_ANGLE = 2.0 * math.pi / CONFIG.odometry.ticks_per_revolution


@pytest.mark.parametrize("file", ROBOTS)
def test_each_robot_is_driven_and_measured_as_alone(file: str) -> None:
    robot = load_robot(ROOT / file)
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    wheels = [robot.urdf.joints[name].max_speed or np.inf for name in robot.drive.wheels]
    rng, tick = np.random.default_rng(3), CONFIG.tick
    batch = BatchDrive(base, limits, np.array(wheels), tick, TICK_ANGLE, 2)
    drives = [Drive(limits), Drive(limits)]
    slower = WheelSpeeds(robot, base)
    counted = [Odometry(CONFIG.odometry, base, rng) for _ in range(2)]
    for one in counted:
        one.reset(base.encoders(np.zeros(len(wheels))).tolist())
    angles = np.zeros((2, len(wheels)))
    for i in range(100):
        commands = rng.uniform(-3.0, 3.0, (2, 3)) * [1.0, 0.0, 2.0]
        speeds = batch.speeds(commands)
        for k, (v, _, w) in enumerate(commands.tolist()):
            drives[k].command(Velocity(v, yaw_rate=w), i * tick)
            wanted = slower.slowed(base.reachable(drives[k].velocity(i * tick, tick)))
            np.testing.assert_allclose(speeds[k], base.speeds(wanted), atol=1e-12)
        angles += speeds * tick
        moved = batch.velocities(angles)
        for k, odometry in enumerate(counted):
            found = odometry.update(base.encoders(angles[k]), tick)
            np.testing.assert_allclose(moved[k], (found.v, found.side, found.w), atol=1e-9)


def test_commands_that_are_not_finite_are_refused() -> None:
    robot = load_robot(ROOT / ROBOTS[0])
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    batch = BatchDrive(base, limits, np.full(4, np.inf), CONFIG.tick, TICK_ANGLE, 3)
    with pytest.raises(CommandError, match=r"robots \[1\] must be finite"):
        batch.speeds(np.array([[0.1, 0.0, 0.0], [np.nan, 0.0, 0.0], [0.1, 0.0, 0.0]]))


def test_a_robot_that_is_put_down_starts_from_rest_and_the_others_drive_on() -> None:
    robot = load_robot(ROOT / ROBOTS[0])
    base, limits = base_of(robot, CONFIG.drive), limited(CONFIG.drive, robot.drive, 1.5)
    most = np.full(len(robot.drive.wheels), np.inf)
    batch = BatchDrive(base, limits, most, CONFIG.tick, TICK_ANGLE, 2)
    ahead = np.tile([0.5, 0.0, 0.0], (2, 1))
    first = batch.speeds(ahead)[0]
    for _ in range(5):
        batch.speeds(ahead)
    batch.restart(np.array([True, False]))
    speeds = batch.speeds(ahead)
    np.testing.assert_allclose(speeds[0], first)
    assert (speeds[1] > 2.0 * first).all()
