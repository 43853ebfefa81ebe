"""Robots of all sizes rest, roll, slide, climb and push as dry friction says."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import run
from tests.sim.generated import Chassis, chassis, level, sill, slope

MADE = list(chassis(6, seed=3))
ROBOTS = pytest.mark.parametrize("chassis", MADE, ids=lambda c: c.name)
STEPS = pytest.mark.parametrize("step", [0.001, 0.004])
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
    ("chassis", "step"), [(c, 0.004) for c in MADE] + [(c, 0.001) for c in MADE[:3]], ids=str
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


@STEPS
@pytest.mark.parametrize("axles", [2, 3])
def test_robot_slides_down_what_friction_cannot_hold(axles: int, step: float) -> None:
    """With the acceleration g (sin - mu cos)."""
    slippery = dataclasses.replace(FOUR_WHEELS, friction=0.3, axles=axles)
    sim = _simulator(slippery, slope(30.0), step)
    first = run(sim, 0.5).truth.v
    angle = math.radians(30.0)
    acceleration = 9.81 * (math.sin(angle) - 0.3 * math.cos(angle))
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
