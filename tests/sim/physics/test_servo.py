"""Gains of motors: wheels as proportional-integral speed control, steering critically damped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_sim.model.robot import SOLO
from arjuna_sim.physics.wheels.servo import ServoConfig, armature
from tests.sim import drive_cases as cases
from tests.sim.builders import simulator


def test_motors_are_as_strong_as_what_they_move_is_heavy(tmp_path: Path) -> None:
    sim = simulator(robot=cases.car("gz").write(tmp_path))
    model, robot, config = sim.stage.scene.model, sim.robot.model, ServoConfig()
    drive, mass = robot.drive, robot.urdf.mass
    share = mass * drive.radius**2 / len(drive.wheels)
    for name in drive.wheels:
        motor, joint = model.actuator(name), model.joint(name)
        damping = (model.dof_M0[joint.dofadr[0]] + share) / config.response_time
        stiffness = damping / config.integral_time
        assert motor.gainprm[0] == pytest.approx(stiffness)
        assert motor.biasprm[:3] == pytest.approx((0.0, -stiffness, -damping))
        assert motor.forcerange == pytest.approx((-drive.torque, drive.torque))
    assert len(drive.steering) == 2
    for name in drive.steering:
        motor, joint = model.actuator(name), model.joint(name)
        moved = model.dof_M0[joint.dofadr[0]] + mass * drive.radius**2 / 2
        stiffness = moved / 0.02**2  # it comes there in 0.02 s
        assert motor.gainprm[0] == pytest.approx(stiffness)
        critical = 2.0 * np.sqrt(stiffness * moved)
        assert motor.biasprm[:3] == pytest.approx((0.0, -stiffness, -critical))
    servos = sim.stage.scene.robots[SOLO].servos
    assert servos.lead.tolist() == [config.integral_time] * len(drive.wheels)
    assert servos.response_time == config.response_time
    assert servos.reach == pytest.approx(
        [drive.torque / model.actuator(name).gainprm[0] for name in drive.wheels]
    )


def test_a_rotor_is_so_heavy_that_a_step_does_not_throw_it_over(tmp_path: Path) -> None:
    robot = simulator(robot=cases.car("gz").write(tmp_path)).robot.model
    share = robot.urdf.mass * robot.drive.radius**2 / len(robot.drive.wheels)
    config = ServoConfig(response_time=0.02)
    assert armature(robot, config, 0.004) == pytest.approx(share * 0.004 / 0.04)
    heavy = ServoConfig(armature=9.0)
    assert armature(robot, heavy, 0.004) == 9.0
