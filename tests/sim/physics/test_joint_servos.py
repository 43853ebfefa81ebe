"""Servos of joints."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.library import Library
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.spawned import read_entity
from arjuna_sim.inputs import named_world
from arjuna_sim.model.robot import SOLO
from arjuna_sim.physics.wheels.servo import ServoConfig, armature
from arjuna_sim.simulation import Simulation, Start, solo
from tests.sim import drive_cases as cases
from tests.sim.arms import CONTROLLERS, JOINTS, write_arm
from tests.sim.builders import simulator

STRETCHED = (0.3, 1.5, 0.1)


def simulation(path: Path, step: float = 0.004) -> Simulation:
    world = named_world(str(shipped_file("worlds/empty.world")))
    rng = np.random.default_rng(0)
    return Simulation(solo(load_robot(path)), world, SimulatorConfig(physics_timestep=step), rng)


def only(name: str) -> dict[str, dict[str, object]]:
    return {name: CONTROLLERS[name]}


def angles(sim: Simulation, ticks: int) -> list[float]:
    for _ in range(ticks):
        seen = sim.drive()
    found = dict(zip(seen.joints.names, seen.joints.positions.tolist(), strict=True))
    return [found[name] for name in JOINTS]


@pytest.mark.parametrize("step", [0.001, 0.004, 0.01])
def test_stretched_arm_is_held_against_its_weight(tmp_path: Path, step: float) -> None:
    sim = simulation(write_arm(tmp_path, only("positions")), step)
    sim.robot.controllers.command("positions", STRETCHED)
    assert angles(sim, 200) == pytest.approx(STRETCHED, abs=1e-3)


def test_weak_motor_gives_way(tmp_path: Path) -> None:
    path = write_arm(tmp_path, only("positions"))
    path.write_text(path.read_text().replace("effort='60'", "effort='0.5'"))
    sim = simulation(path)
    sim.robot.controllers.command("positions", STRETCHED)
    _, elbow, _ = angles(sim, 200)
    assert elbow > 2.0


def test_gains_of_the_file_sag_as_much_as_they_say(tmp_path: Path) -> None:
    tags = "<joint_name>elbow</joint_name><p_gain>100</p_gain><d_gain>20</d_gain>"
    tags += "<initial_position>1.2</initial_position>"
    other = "".join(
        f"<plugin filename='gz-sim-joint-position-controller-system' name='{name}'>"
        f"<joint_name>{name}</joint_name></plugin>"
        for name in ("shoulder", "wrist")
    )
    extra = (
        "<gazebo><plugin filename='gz-sim-joint-position-controller-system' name='p'>"
        f"{tags}</plugin>{other}</gazebo>"
    )
    sim = simulation(write_arm(tmp_path, extra=extra))
    (name,) = (c.name for c in sim.robot.model.settings.controllers if "elbow" in c.joints)
    sim.robot.controllers.command(name, [1.2])
    _, elbow, wrist = angles(sim, 300)
    # fore of 1 kg at 0.15 m, hand of 0.5 kg at 0.35 m, fingers of 0.1 kg at 0.445 m
    arm = 0.15 + 0.5 * 0.35 + 0.1 * 0.445
    assert wrist == pytest.approx(0.0, abs=2e-3)
    assert 100.0 * (elbow - 1.2) == pytest.approx(9.81 * arm * np.sin(elbow), abs=0.25)


def test_arms_of_two_robots_move_apart(tmp_path: Path) -> None:
    robot = load_robot(write_arm(tmp_path, only("positions")))
    starts = {name: Start(robot, SE2(x, 0.0, 0.0)) for name, x in (("a", 0.0), ("b", 3.0))}
    world, rng = named_world(str(shipped_file("worlds/empty.world"))), np.random.default_rng(0)
    sim = Simulation(starts, world, SimulatorConfig(), rng)
    sim.robots["a"].controllers.command("positions", (0.5, 0.4, -0.3))
    for _ in range(60):
        seen = sim.step({})
    assert seen["a"].joints.positions[:3] == pytest.approx((0.5, 0.4, -0.3), abs=1e-3)
    assert seen["b"].joints.positions[:3] == pytest.approx((0.0, 0.25, 0.0), abs=1e-3)


def test_arm_keeps_its_pose_through_a_spawn_and_a_reset_returns_it(tmp_path: Path) -> None:
    sim = simulation(write_arm(tmp_path, only("positions")))
    sim.robot.controllers.command("positions", STRETCHED)
    angles(sim, 100)
    library = Library(tmp_path, SearchPath.of())
    entity = read_entity("box:0.2,0.2,0.2", "", library)
    sim.stage.spawn(dataclasses.replace(entity, start=Pose3((3.0, 0.0, 0.0))))
    assert angles(sim, 50) == pytest.approx(STRETCHED, abs=1e-3)
    sim.reset()
    assert angles(sim, 50) == pytest.approx((0.0, 0.25, 0.0), abs=1e-3)


def test_same_commands_move_it_alike(tmp_path: Path) -> None:
    ends = []
    for _ in range(2):
        sim = simulation(write_arm(tmp_path, CONTROLLERS))
        sim.robot.controllers.command("gripper", [0.02])
        sim.robot.controllers.switch(["speeds"], ["arm_controller"], False)
        sim.robot.controllers.command("speeds", (0.4, -0.3, 0.2))
        ends.append(angles(sim, 100))
    assert ends[0] == ends[1]
    assert ends[0] == pytest.approx((0.8, -0.35, 0.4), abs=2e-3)


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
        stiffness = moved / 0.018**2  # it comes there in 0.018 s
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
