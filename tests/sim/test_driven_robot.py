"""A driven robot: how it moves, holds commands and observes."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.controller import CommandError
from tests.sim.builders import EMPTY, ROOM, run, simulator
from tests.sim.files.test_robots import TWO, _robot
from tests.sim.robot_files.tags import plugin


def test_idle_robot_stays() -> None:
    """At a rate of less than a millimetre in ten minutes."""
    sim = simulator(config=SimulatorConfig(tick=0.1))
    start = sim.robot.truth()
    end = run(sim, 20.0).truth
    assert start.pose.distance(end.pose) < 3e-5
    assert abs(wrap(end.pose.theta - start.pose.theta)) < 3e-5
    assert abs(end.z) < 1e-3
    assert abs(end.v) < 1e-5


@pytest.mark.parametrize("speed", [0.3, 1.0])
def test_encoders_measure_a_straight_metre_within_two_per_cent(speed: float) -> None:
    sim = simulator()
    last = run(sim, 1.0 / speed, Velocity(speed))
    last = run(sim, 1.0, Velocity())
    assert last.odometry.T_odom_base.x == pytest.approx(last.truth.pose.x, rel=0.02)
    assert last.truth.pose.x == pytest.approx(1.0, rel=0.02)
    assert abs(last.truth.pose.y) < 0.01


@pytest.mark.parametrize(
    ("speed", "rate"),
    [(0.0, -1.0), (0.0, 1.5), (0.3, 0.4), (0.3, -2.0), (0.6, 1.0), (0.6, 1.5), (0.6, -2.0)],
)
def test_calibrated_encoders_measure_spins_and_arcs(speed: float, rate: float) -> None:
    """A quarter turn from rest to rest: 4 % of the angle, 2 % of the path along the robot.

    Across, and along in sharp turns, a robot that turns by sliding is carried on by its speed.
    """
    sim = simulator()
    moving = round(math.pi / 2 / abs(rate) / sim.config.tick)
    seen = [
        sim.drive(Velocity(speed, yaw_rate=rate) if i < moving else Velocity())
        for i in range(moving + 50)
    ]
    odometry = np.array([o.odometry.T_odom_base.array() for o in seen])
    truth = np.array([o.truth.pose.array() for o in seen])
    assert odometry[-1, 2] == pytest.approx(truth[-1, 2], rel=0.04)
    assert truth[-1, 2] == pytest.approx(math.copysign(math.pi / 2, rate), rel=0.04)
    if speed > 0.0:
        slip = 0.02 if abs(rate) <= 1.0 else 0.06
        assert _path_along(odometry) == pytest.approx(_path_along(truth), rel=slip)


def _path_along(poses: NDArray[np.float64]) -> float:
    heading = (poses[1:, 2] + poses[:-1, 2]) / 2
    steps = np.diff(poses[:, :2], axis=0)
    return float((steps * np.column_stack((np.cos(heading), np.sin(heading)))).sum())


@pytest.mark.parametrize("command", [Velocity(yaw_rate=2.0), Velocity(0.6, yaw_rate=2.0)])
def test_wheels_do_not_hop_while_they_slip(command: Velocity) -> None:
    sim = simulator()
    run(sim, 3.0, command)
    assert np.ptp([sim.drive(command).truth.pitch for _ in range(100)]) < 1e-5


def test_wheels_slip_when_it_turns() -> None:
    """Friction, not kinematics, turns the robot: by the wheel separation it would turn faster."""
    sim = simulator()
    start = run(sim, 2.0, Velocity(yaw_rate=1.0))
    wheels = sim.robot.wheel_angles()
    end = run(sim, 2.0, Velocity(yaw_rate=1.0))
    left, right = (b - a for a, b in zip(wheels, sim.robot.wheel_angles(), strict=True))
    by_separation = (right - left) * sim.robot.model.drive.radius / sim.robot.model.drive.separation
    turned = wrap(end.truth.pose.theta - start.truth.pose.theta)
    # Dry friction on four wheels: track^2 / (track^2 + wheelbase^2).
    assert turned / by_separation == pytest.approx(0.34**2 / (0.34**2 + 0.30**2), abs=0.03)


def test_turning_does_not_depend_on_the_physics_time_step() -> None:
    turns = []
    for timestep in (0.001, 0.004):
        sim = simulator(config=SimulatorConfig(physics_timestep=timestep))
        start = run(sim, 1.0, Velocity(0.3, yaw_rate=1.0)).truth.pose.theta
        turns.append((start, run(sim, 1.5, Velocity(0.3, yaw_rate=1.0)).truth.pose.theta - start))
    assert turns[0][0] == pytest.approx(turns[1][0], abs=0.03)  # from rest
    assert turns[0][1] == pytest.approx(turns[1][1], abs=0.004)


def test_acceleration_is_limited() -> None:
    sim = simulator()
    speeds = [sim.drive(Velocity(1.0)).truth.v for _ in range(50)]
    limit = sim.robot.model.drive.max_acceleration
    assert max(np.diff(speeds)) / sim.config.tick < 1.2 * limit < 4.0
    assert speeds[-1] == pytest.approx(1.0, abs=0.02)


def test_robot_stops_after_the_command_timeout() -> None:
    sim = simulator()
    run(sim, 1.0, Velocity(0.5))
    assert run(sim, 0.28).truth.v == pytest.approx(0.5, abs=0.02)
    assert abs(run(sim, 0.26).truth.v) < 0.03
    assert abs(run(sim, 0.4).truth.v) < 0.01


def test_its_setpoint_is_what_its_wheels_are_set_to() -> None:
    sim = simulator()
    assert sim.robot.setpoint == Velocity()
    sim.drive(Velocity(9.0))
    assert 0.0 < sim.robot.setpoint.x < 0.5, "it ramps"
    run(sim, 1.5, Velocity(9.0))
    assert sim.robot.setpoint == Velocity(1.0)
    run(sim, 1.5, Velocity())
    assert sim.robot.setpoint == Velocity()


def test_limits_of_the_drive_change_while_it_runs() -> None:
    sim = simulator()
    run(sim, 1.0, Velocity(1.0))
    drive = dataclasses.replace(sim.config.drive, max_linear_velocity=0.2)
    sim.adjust(dataclasses.replace(sim.config, drive=drive))
    assert run(sim, 1.0, Velocity(1.0)).truth.v == pytest.approx(0.2, abs=0.01)


def test_command_that_is_not_finite_is_refused() -> None:
    with pytest.raises(CommandError, match="must be finite"):
        simulator().drive(Velocity(math.nan))


def test_driving_into_the_red_box_reports_a_contact_and_stops_the_robot() -> None:
    sim = simulator(ROOM)
    assert run(sim, 2.0, Velocity(0.5)).contacts == ()
    last = run(sim, 5.0, Velocity(0.5))
    assert last.contacts == ("obstacle_red",)
    assert last.truth.pose.x == pytest.approx(2.5 - 0.25 - 0.225, abs=0.03)


def test_kidnapped_robot_keeps_its_odometry() -> None:
    sim = simulator(ROOM)
    before = run(sim, 1.0, Velocity(0.3, yaw_rate=0.2))
    sim.robot.set_pose(SE2(-3.0, 3.5, 2.0))
    after = sim.drive(Velocity())
    assert after.truth.pose.distance(SE2(-3.0, 3.5, 2.0)) < 1e-3
    assert after.truth.pose.theta == pytest.approx(2.0, abs=1e-3)
    assert after.odometry.T_odom_base.distance(before.odometry.T_odom_base) < 0.02
    assert after.imu is not None
    assert np.linalg.norm(after.imu.linear_acceleration) < 15.0  # no jolt of the journey


def test_time_has_no_drift() -> None:
    sim = simulator()
    times = [sim.drive().time for _ in range(1000)]
    assert times[2] == 0.06
    assert times[-1] == 20.0


def test_sensors_come_at_their_rates() -> None:
    sim = simulator()
    observations = [sim.drive() for _ in range(500)]
    scans = [o.time for o in observations if o.scan is not None]
    assert scans == [round(0.1 * i, 9) for i in range(1, 101)]
    assert all(o.scan.stamp == o.time for o in observations if o.scan is not None)
    assert sum(o.imu is not None for o in observations) == 500


def test_tick_must_be_a_whole_number_of_physics_steps() -> None:
    with pytest.raises(ConfigError, match="whole number of 'physics_timestep'"):
        simulator(EMPTY, SimulatorConfig(tick=0.02, physics_timestep=0.003))


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


@pytest.mark.parametrize(
    ("file", "speed"),
    [("gz-sim-diff-drive-system", 8.0), ("libgazebo_ros_diff_drive.so", 16.0)],
)
def test_drives_of_gazebo_classic_know_no_speed_of_joints(
    tmp_path: Path, file: str, speed: float
) -> None:
    named = "".join(f"<{s}_joint>{s}_wheel_joint</{s}_joint>" for s in ("left", "right"))
    limited = TWO.replace("</joint>", '<limit effort="9" velocity="8"/></joint>')
    sim = simulator(robot=_robot(tmp_path, limited + plugin(file, named)))
    ahead = Velocity(16.0 * sim.robot.model.drive.radius)
    for _ in range(200):
        last = sim.drive(ahead).joints
    turning = dict(zip(last.names, last.velocities, strict=True))
    assert turning["left_wheel_joint"] == pytest.approx(speed, rel=0.02)
