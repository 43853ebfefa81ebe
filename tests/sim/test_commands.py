"""How far a robot drives by commands as people and nodes send them, and what bounds it."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.simulation import Simulation
from tests.sim.builders import simulator
from tests.sim.files.test_robots import FOUR, TWO, _robot

_SLOW = Velocity(0.2)


def _driven(sim: Simulation, hertz: float, seconds: float, silent: float = 0.0) -> list[float]:
    """Return the true way [m] after each tick of commands at a rate, then of silence."""
    ways, period = [], round(1.0 / (hertz * sim.config.tick))
    for tick in range(round((seconds + silent) / sim.config.tick)):
        sent = tick * sim.config.tick < seconds and tick % period == 0
        ways.append(sim.drive(_SLOW if sent else None).truth.pose.x)
    return ways


@pytest.mark.parametrize("hertz", [0.5, 0.8, 1.0, 2.0, 3.0, 5.0, 20.0, 50.0])
def test_any_rate_of_commands_drives_the_whole_way(hertz: float) -> None:
    """`ros2 topic pub` sends one a second, by which Gazebo's robots drive evenly."""
    ways = _driven(simulator(), hertz, 10.0)
    late = 0.5 * 0.2 if hertz == 0.5 else 0.0  # its period is known from its second command on
    assert 1.9 - late < ways[-1] <= 2.0


@pytest.mark.parametrize("hertz", [5.0, 20.0, 50.0])
def test_quick_sender_that_falls_silent_leaves_half_a_second(hertz: float) -> None:
    sim = simulator()
    ways = _driven(sim, hertz, 4.0, 2.0)
    at = round(4.0 / sim.config.tick)
    assert ways[-1] - ways[at - 1] < 0.5 * 0.2
    assert ways[-1] - ways[at + round(0.55 / sim.config.tick)] < 1e-3


def test_time_out_of_zero_drives_on_by_one_command() -> None:
    """As Gazebo's plug-ins do after `ros2 topic pub --once`."""
    sim = simulator(config=SimulatorConfig(drive=DriveConfig(command_timeout=0.0)))
    sim.drive(_SLOW)
    for _ in range(500):
        last = sim.drive()
    assert last.truth.pose.x == pytest.approx(2.0, abs=0.03)


def test_robot_of_another_has_no_limits_of_ours(tmp_path: Path) -> None:
    sim = simulator(robot=_robot(tmp_path, FOUR))
    for _ in range(200):
        last = sim.drive(Velocity(1.6))
    assert last.truth.v == pytest.approx(1.6, rel=0.02)
    for _ in range(200):
        last = sim.drive(Velocity(yaw_rate=2.6))
    assert sim.robot.setpoint.yaw_rate == 2.6
    assert sim.robot.take_cuts() == ()


def test_joints_speed_slows_the_robot_along_its_curve_and_is_said_once(tmp_path: Path) -> None:
    limited = TWO.replace('type="continuous"', 'type="continuous" ').replace(
        "</joint>", '<limit effort="9" velocity="8"/></joint>'
    )
    sim = simulator(robot=_robot(tmp_path, limited))
    for _ in range(100):
        last = sim.drive(Velocity(0.8, yaw_rate=2.0))
    assert sim.robot.setpoint.yaw_rate / sim.robot.setpoint.x == pytest.approx(2.0 / 0.8)
    wheels = last.joints
    speeds = dict(zip(wheels.names, wheels.velocities, strict=True))
    assert max(map(abs, speeds.values())) == pytest.approx(8.0, rel=0.02)
    (said,) = sim.robot.take_cuts()
    assert "by the velocity 8 rad/s in the <limit> of joint 'right_wheel_joint'" in said


@pytest.mark.parametrize("asked", [1e3, 1e9, -1e30])
def test_speed_beyond_all_sense_is_cut_and_said(tmp_path: Path, asked: float) -> None:
    """It would be too much for the physics' time step, which else ends the simulation."""
    sim = simulator(robot=_robot(tmp_path, FOUR))
    for _ in range(100):
        last = sim.drive(Velocity(asked, yaw_rate=-asked))
    assert abs(last.truth.v) < 60.0
    assert sum("what the physics can step" in text for text in sim.robot.take_cuts()) == 2
