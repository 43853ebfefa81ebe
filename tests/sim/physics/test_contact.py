"""Robots of all sizes rest, roll, slide, climb, push and pull away as dry friction says."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.world import World
from arjuna_sim.physics.wheels.traction import LEAST
from arjuna_sim.simulation import Simulation, solo
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts
from tests.sim.generated import Chassis, chassis, level, sill, slope

MADE = list(chassis(6, seed=3))
ROBOTS = pytest.mark.parametrize("chassis", MADE, ids=lambda c: c.name)
BETWEEN = [
    Chassis(mass, radius, 1, wheel_share=share, casters=2)
    for mass, radius, share in ((3.0, 0.03, 0.1), (15.0, 0.1, 0.2), (55.0, 0.2, 0.35))
]
FOUR_WHEELS = Chassis()


def _simulator(chassis: Chassis, world: World, step: float = 0.004) -> Simulation:
    config = SimulatorConfig(physics_timestep=step)
    return Simulation(solo(chassis.robot()), world, config, np.random.default_rng(0))


def _box(size: float, mass: float, x: float) -> Entity:
    part = Part(Shape(Kind.BOX, (size, size, size)), Pose3((0.0, 0.0, size / 2)))
    return Entity("box", (part,), start=Pose3((x, 0.0, 0.0)), mass=mass)


@ROBOTS
def test_robot_parked_on_a_slope_stays(chassis: Chassis) -> None:
    """At a rate of less than a millimetre in ten minutes."""
    sim = _simulator(chassis, slope(10.0))
    start = run(sim, 4.0).truth.pose
    assert start.distance(run(sim, 3.0).truth.pose) < 3.0 / 600.0 * 1e-3


@pytest.mark.parametrize(
    ("chassis", "step"),
    [(c, 0.004) for c in MADE + BETWEEN] + [(c, 0.001) for c in MADE[:3]],
    ids=str,
)
def test_robot_drives_a_metre_and_is_never_much_too_fast(chassis: Chassis, step: float) -> None:
    sim = _simulator(chassis, level(), step)
    seen = [sim.drive(Velocity(0.4) if i < 125 else Velocity()).truth for i in range(175)]
    assert seen[-1].pose.x == pytest.approx(1.0, rel=0.03)
    assert abs(seen[-1].pose.y) < 0.01
    assert max(truth.v for truth in seen) < 1.1 * 0.4


@ROBOTS
def test_robot_turns_as_coulomb_says(chassis: Chassis) -> None:
    """The drive knows how the wheels slip: a quarter turn is one, within 5 degrees."""
    sim = _simulator(chassis, level())
    run(sim, math.pi / 2 / 0.8, Velocity(yaw_rate=0.8))
    turned = run(sim, 1.0, Velocity()).truth.pose.theta
    assert math.degrees(wrap(turned - math.pi / 2)) == pytest.approx(0.0, abs=5.0)


@pytest.mark.parametrize(
    ("wheels", "ground", "axles", "step"),
    [(0.2, None, 2, 0.004), (0.2, 5.0, 2, 0.001), (0.2, 0.2, 3, 0.004), (1.0, 0.2, 3, 0.001)],
)
def test_robot_slides_down_what_the_more_slippery_surface_cannot_hold(
    wheels: float, ground: float | None, axles: int, step: float
) -> None:
    """With the acceleration g (sin - mu cos)."""
    slippery = dataclasses.replace(FOUR_WHEELS, friction=wheels, axles=axles)
    sim = _simulator(slippery, slope(25.0, ground), step)
    first = run(sim, 0.5).truth.v
    angle = math.radians(25.0)
    acceleration = 9.81 * (math.sin(angle) - 0.2 * math.cos(angle))
    assert run(sim, 1.0).truth.v - first == pytest.approx(-acceleration, rel=0.03)


@ROBOTS
def test_ramp_of_20_degrees_is_climbed_at_nine_tenths_of_the_command(chassis: Chassis) -> None:
    sim = _simulator(dataclasses.replace(chassis, friction=1.5, grip=3.0), slope(20.0))
    run(sim, 2.0, Velocity(0.3))
    assert run(sim, 0.5, Velocity(0.3)).truth.v > 0.9 * 0.3


@pytest.mark.parametrize("radius", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("axles", [2, 3])
def test_sill_of_a_third_of_the_wheels_radius_is_crossed(axles: int, radius: float) -> None:
    robot = Chassis(500.0 * radius, radius, axles)
    edge = 8.0 * radius
    sim = _simulator(robot, sill(0.3 * radius, edge, radius))
    assert run(sim, 20.0 * radius / 0.3 + 3.0, Velocity(0.3)).truth.pose.x > 2.0 * edge


@pytest.mark.parametrize(("share", "touches"), [(0.1, False), (0.28, False), (0.9, True)])
@pytest.mark.parametrize("heading", [0.0, 1e-3, 0.5, 0.9])
@pytest.mark.parametrize("speed", [0.2, 0.5])
def test_wheels_touch_no_board_that_they_roll_over(
    share: float, touches: bool, heading: float, speed: float
) -> None:
    radius = 0.1
    world = sill(share * radius, 6.0 * radius, radius)
    config, start = SimulatorConfig(), SE2(0.0, 0.0, heading)
    robot = Chassis(20.0, radius).robot()
    sim = Simulation(solo(robot, start), world, config, np.random.default_rng(0))
    ticks = round(15.0 * radius / math.cos(heading) / speed / config.tick)
    seen = [sim.drive(Velocity(speed)) for _ in range(ticks)]
    assert any(each.contacts == ("sill",) for each in seen) == touches
    assert (seen[-1].truth.pose.x > 9.0 * radius) != touches


def test_heavy_box_stands_when_a_light_robot_pushes() -> None:
    sim = _simulator(dataclasses.replace(FOUR_WHEELS, mass=3.5), level())
    sim.stage.spawn(_box(0.5, 100.0, 1.0))
    run(sim, 8.0, Velocity(0.5))
    assert sim.robot.truth().pose.x > 0.4  # it is there, and pushes
    assert sim.stage.motion("box").pose.position[0] == pytest.approx(1.0, abs=1e-3)


def test_light_box_is_pushed() -> None:
    sim = _simulator(FOUR_WHEELS, level())
    sim.stage.spawn(_box(0.3, 1.0, 0.6))
    run(sim, 6.0, Velocity(0.3))
    assert sim.stage.motion("box").pose.position[0] > 1.2


def test_wheel_that_was_held_does_not_make_up_for_it() -> None:
    sim = _simulator(FOUR_WHEELS, level())
    sim.stage.spawn(_box(0.5, 0.0, 0.8))
    run(sim, 10.0, Velocity(0.3))
    sim.stage.delete("box")
    assert max(sim.drive(Velocity(0.3)).truth.v for _ in range(100)) < 1.2 * 0.3


def test_robot_without_torque_stands_on_the_ramp_it_cannot_climb() -> None:
    weak = dataclasses.replace(FOUR_WHEELS, grip=0.1)  # 10 degrees take 0.17
    sim = _simulator(weak, slope(10.0))
    assert run(sim, 3.0, Velocity(0.3)).truth.v < -0.3


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


def test_robot_that_hardly_drives_says_so() -> None:
    rubbing = Chassis(axles=1, casters=2, friction=0.2, rubs=2.0)
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
