"""Friction is that of the files, and robots pull away no harder than they grip and stand."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.world import World
from arjuna_sim.physics.wheels.traction import LEAST
from arjuna_sim.simulation import Simulation, solo
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts
from tests.sim.generated import Chassis, level, slope

FOUR_WHEELS = Chassis()
BETWEEN = [
    Chassis(mass, radius, 1, wheel_share=share, casters=2)
    for mass, radius, share in ((3.0, 0.03, 0.1), (15.0, 0.1, 0.2), (55.0, 0.2, 0.35))
]


def _simulator(chassis: Chassis, world: World) -> Simulation:
    return Simulation(solo(chassis.robot()), world, SimulatorConfig(), np.random.default_rng(0))


@pytest.mark.parametrize(("ground", "wheels"), [(0.2, 1.0), (5.0, 0.2), (0.2, 0.2)])
def test_the_more_slippery_of_two_surfaces_holds(ground: float, wheels: float) -> None:
    sim = _simulator(dataclasses.replace(FOUR_WHEELS, friction=wheels), slope(25.0, ground))
    first = run(sim, 0.5).truth.v
    angle = math.radians(25.0)
    acceleration = 9.81 * (math.sin(angle) - 0.2 * math.cos(angle))
    assert run(sim, 1.0).truth.v - first == pytest.approx(-acceleration, rel=0.03)


def test_robot_is_parked_on_a_slope_where_both_surfaces_grip() -> None:
    sim = _simulator(FOUR_WHEELS, slope(10.0, 0.5))
    start = run(sim, 2.0).truth.pose
    assert start.distance(run(sim, 6.0).truth.pose) < 1e-5


def test_friction_of_a_caster_is_what_its_file_says() -> None:
    said = dataclasses.replace(FOUR_WHEELS, axles=1, rubs=0.3).robot()
    unsaid = dataclasses.replace(FOUR_WHEELS, axles=1).robot()
    assert said.settings.friction["caster0"] == 0.3
    assert unsaid.settings.friction["caster0"] == 0.01


@pytest.mark.parametrize("friction", [0.1, 0.2, 1.0])
def test_robot_pulls_away_as_hard_as_it_grips(friction: float) -> None:
    """So that it comes as far as commanded, on ice as well."""
    sim = _simulator(dataclasses.replace(FOUR_WHEELS, friction=friction, grip=9.0), level())
    steady = sim.stage.scene.robots[SOLO].support.steady
    assert steady == pytest.approx(max(LEAST, 0.8 * friction * 9.81), rel=0.1)
    run(sim, 1.0 / 0.4, Velocity(0.4))
    assert run(sim, 1.5, Velocity()).truth.pose.x == pytest.approx(1.0, rel=0.03)


@pytest.mark.parametrize("axles", [1, 2, 3])
@pytest.mark.parametrize("friction", [1.5, 2.5, 200.0, 1e9])
def test_robot_turns_on_the_spot_however_much_its_wheels_grip(friction: float, axles: int) -> None:
    """Files copy 100 or 200 from each other; wheels that held as hard would not slide at all."""
    chassis = dataclasses.replace(FOUR_WHEELS, friction=friction, axles=axles, casters=2)
    sim = _simulator(chassis, level())
    turned = run(sim, 3.0, Velocity(yaw_rate=0.5)).truth.pose.theta
    assert turned == pytest.approx(1.5, rel=0.06)
    is_taken_down = friction > 2.0 and axles > 1
    assert sim.robot.model.settings.friction["wheel_l0"] == (1.0 if is_taken_down else friction)
    notes = [note for note in texts(sim.robot.model.notes) if "is taken to be 1" in note]
    assert len(notes) == is_taken_down


@pytest.mark.parametrize("friction", [1.5, 150.0])
def test_steered_wheels_that_slide_as_they_steer_do_not_lift_the_robot(
    friction: float, tmp_path: Path
) -> None:
    file = cases.car("gz").write(tmp_path)
    links = load_robot(file).urdf.links
    tags = "".join(f"<gazebo reference='{n}'><mu1>{friction}</mu1></gazebo>" for n in links)
    file.write_text(file.read_text().replace("</robot>", f"{tags}</robot>"))
    robot = load_robot(file)
    taken = {robot.settings.friction[robot.urdf.joints[n].child] for n in robot.drive.rolling}
    assert taken == {1.0 if friction > 2.0 else friction}
    assert any("overturn" in note for note in texts(robot.notes)) is (friction > 2.0)


@pytest.mark.parametrize("chassis", BETWEEN, ids=lambda c: c.name)
def test_robot_on_wheels_between_casters_is_never_much_too_fast(chassis: Chassis) -> None:
    sim = _simulator(chassis, level())
    speeds = [sim.drive(Velocity(0.3)).truth.v for _ in range(100)]
    assert max(speeds) < 1.1 * 0.3


def test_robot_that_hardly_drives_says_so() -> None:
    rubbing = Chassis(axles=1, casters=2, friction=0.2, rubs=5.0)
    assert any("hardly drives" in note for note in _simulator(rubbing, level()).notes)
    assert not any("hardly drives" in note for note in _simulator(FOUR_WHEELS, level()).notes)


def test_robot_whose_wheels_are_in_the_air_says_so() -> None:
    raised = dataclasses.replace(FOUR_WHEELS, axles=1, casters=2, low=0.05)
    assert any("hardly drives" in note for note in _simulator(raised, level()).notes)


def test_wheel_that_turns_off_its_middle_is_named() -> None:
    limping = dataclasses.replace(FOUR_WHEELS, limp=0.3).robot()
    assert sum("middle of its wheel" in note for note in texts(limping.notes)) == 4
    nearly = dataclasses.replace(FOUR_WHEELS, limp=0.02)
    assert not any("middle of its wheel" in note for note in texts(nearly.robot().notes))
    speeds = [run(_simulator(nearly, level()), 0.7, Velocity(0.3)).truth.v]
    assert max(speeds) == pytest.approx(0.3, rel=0.02)


def test_world_pulls_as_its_file_says(tmp_path: Path) -> None:
    path = tmp_path / "moon.world"
    path.write_text(
        "<sdf version='1.6'><world name='moon'><gravity>0 0 -1.62</gravity></world></sdf>"
    )
    seen = run(simulator(path), 2.0)
    assert seen.imu is not None
    assert float(seen.imu.linear_acceleration[2]) == pytest.approx(1.62, abs=0.05)
    path.write_text(path.read_text().replace("-1.62", "-1e9"))
    world = load_world(path)
    assert world.gravity == World.gravity
    assert any("gravity" in note for note in texts(world.notes))
