"""Bases of every kind of drive."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.driving.bases import RollerBase, SidesBase
from arjuna_sim.devices.driving.steered import SteeredBase, SteeredWheel, SwerveBase
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind, DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Joint, Link
from tests.sim.wheeled import ALONG_Y, wheeled

AHEAD = np.array([1.0, 0.0])
LENGTH, TRACK, RADIUS, LIMIT = 1.2, 0.6, 0.1, 0.6


def car(axle: float = 0.0, signs: tuple[float, float] = (1.0, 1.0)) -> SteeredBase:
    """Return a car that is driven behind, on an axle, and steers in front of it."""
    positions = [np.array([axle, TRACK / 2]), np.array([axle, -TRACK / 2])]
    behind = [SteeredWheel(position, AHEAD, RADIUS, -1, position) for position in positions]
    pivots = np.array([[axle + LENGTH, TRACK / 2], [axle + LENGTH, -TRACK / 2]])
    front = [SteeredWheel(pivot, AHEAD, RADIUS, i, pivot) for i, pivot in enumerate(pivots)]
    return SteeredBase(behind, front, pivots, np.array(signs), LIMIT)


@pytest.mark.parametrize("axle", [0.0, -0.4])
@pytest.mark.parametrize("bend", [0.0, 0.4, -0.4])
def test_a_cars_wheels_all_roll_about_one_centre(axle: float, bend: float) -> None:
    base, velocity = car(axle, (1.0, -1.0)), Velocity(0.5, yaw_rate=0.5 * bend)
    across = np.array([TRACK / 2, -TRACK / 2])
    inner = np.array([math.atan(LENGTH * bend / (1.0 - bend * y)) for y in across])
    assert base.angles(velocity) == pytest.approx(inner * (1.0, -1.0))
    assert base.speeds(velocity) == pytest.approx(0.5 * (1.0 - bend * across) / RADIUS)
    turns = base.speeds(velocity) * 0.01
    path, side, turn = base.motion(turns, base.angles(velocity))
    assert (path, turn) == pytest.approx((0.005, 0.005 * bend))
    assert side == pytest.approx(-axle * turn)  # the root swings as the axle does not


@pytest.mark.parametrize("bend", [0.0, 0.4, -0.4])
def test_wheels_that_steer_and_drive_turn_as_fast_as_they_go(bend: float) -> None:
    pivots = np.array([[LENGTH, TRACK / 2], [LENGTH, -TRACK / 2]])
    front = [SteeredWheel(pivot, AHEAD, RADIUS, i, pivot) for i, pivot in enumerate(pivots)]
    rear = SteeredWheel(np.zeros(2), AHEAD, RADIUS, -1, np.zeros(2))
    base = SteeredBase(front, [rear], pivots, np.ones(2), LIMIT)
    velocity = Velocity(0.5, yaw_rate=0.5 * bend)
    directions = np.column_stack((1.0 - bend * pivots[:, 1], bend * pivots[:, 0]))
    speeds = base.speeds(velocity)
    assert speeds == pytest.approx(0.5 * np.hypot(*directions.T) / RADIUS)
    moved = base.motion(speeds * 0.1, base.angles(velocity))
    assert moved == pytest.approx((0.05, 0.0, 0.05 * bend))


@pytest.mark.parametrize("beyond", [-0.015, 0.0, 0.1])
@pytest.mark.parametrize("direction", [math.pi / 2, -math.pi / 2, 1.6, -1.5])
def test_a_wheel_that_swerves_keeps_its_side_however_often_it_is_asked(
    beyond: float, direction: float
) -> None:
    """Also where it may not turn a whole quarter, and either side is as far."""
    pivots = np.array([[LENGTH, TRACK / 2], [0.0, -TRACK / 2]])
    wheels = [SteeredWheel(pivot, AHEAD, RADIUS, i, pivot) for i, pivot in enumerate(pivots)]
    base = SwerveBase(wheels, [], pivots, np.ones(2), math.pi / 2 + beyond)
    velocity = Velocity(0.5 * math.cos(direction), y=0.5 * math.sin(direction))
    first = base.angles(velocity).copy()
    assert all(base.angles(velocity) == pytest.approx(first) for _ in range(3))


def test_a_car_bends_no_more_than_its_wheels_turn_in() -> None:
    most = 1.0 / (LENGTH / math.tan(LIMIT) + TRACK / 2)
    for v, w, expected in (
        (1.0, 9.0, most),
        (1.0, -9.0, -most),
        (-2.0, 9.0, 2.0 * most),
        (1.0, 0.3 * most, 0.3 * most),
        (0.0, 1.0, 0.0),
    ):
        found = car().reachable(Velocity(v, y=7.0, yaw_rate=w))
        assert (found.x, found.yaw_rate, found.y) == pytest.approx((v, expected, 0.0))
    angles = car().angles(Velocity(1.0, yaw_rate=most))
    assert angles.max() == pytest.approx(LIMIT)  # of the inner wheel
    assert angles.min() < LIMIT - 0.05
    assert np.abs(car().angles(Velocity(0.01, yaw_rate=9.0))).max() == pytest.approx(LIMIT)


@pytest.mark.parametrize("rake", [0.0, 0.3])
def test_a_fork_that_leans_steers_about_its_axis_at_the_wheel(rake: float) -> None:
    """Its hinge is 0.4 m above the wheel, and behind it by as much as it leans."""
    urdf = wheeled(((LENGTH, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, -0.3, 0.0)))
    T_base_fork = Pose3.from_rpy((LENGTH - 0.4 * math.tan(rake), 0.0, 0.4), (0.0, -rake, 0.0))
    T_fork_wheel = T_base_fork.inverse() @ urdf.joints["a"].T_parent_child
    joints = {
        "steer": Joint("steer", "revolute", "base", "fork", T_base_fork, (0.0, 0.0, 1.0)),
        "a": replace(urdf.joints["a"], parent="fork", T_parent_child=T_fork_wheel),
    }
    links = {**urdf.links, "fork": Link("fork", None, (), ())}
    made = replace(urdf, links=links, joints={**urdf.joints, **joints})
    drive = DriveSettings(("a",), (), 0.6, RADIUS, 1.0, 0.6, RADIUS)
    drive = replace(drive, steering=("steer",), steering_limit=LIMIT, free=("b", "c"))
    base = SteeredBase.of(made, replace(drive, kind=DriveKind.STEERED))
    assert base.angles(Velocity(1.0, yaw_rate=0.4)) == pytest.approx(math.atan(0.4 * LENGTH))


def test_a_car_that_stands_keeps_its_steering() -> None:
    base = car()
    assert base.angles(Velocity()) == pytest.approx((0.0, 0.0))
    held = base.angles(Velocity(0.5, yaw_rate=0.2)).tolist()
    assert base.angles(Velocity(9e-4, yaw_rate=-0.2)).tolist() == held
    assert base.angles(Velocity(1e-3)).tolist() == [0.0, 0.0]
    backward = car().angles(Velocity(-0.5, yaw_rate=0.2))
    assert backward == pytest.approx(car().angles(Velocity(0.5, yaw_rate=-0.2)))


def test_a_base_that_steers_all_wheels_turns_about_the_middle_of_them() -> None:
    pivots = np.array([[0.5, 0.0], [-0.3, 0.0]])
    wheels = [SteeredWheel(pivot, AHEAD, RADIUS, i, pivot) for i, pivot in enumerate(pivots)]
    base = SteeredBase(wheels, [], pivots, np.ones(2), LIMIT)
    front, rear = base.angles(Velocity(1.0, yaw_rate=0.5)).tolist()
    assert math.tan(front) == pytest.approx(0.4 * 0.5)
    assert rear == pytest.approx(-front)


@pytest.mark.parametrize("seed", range(3))
def test_rollers_make_any_motion_of_the_base_turns_and_back(seed: int) -> None:
    x, y, radius = 0.3, 0.2, 0.1
    corners = ((x, y), (x, -y), (-x, y), (-x, -y))
    urdf = wheeled([(*corner, 0.0) for corner in corners])
    grips = tuple((math.sqrt(0.5), s * math.sqrt(0.5)) for s in (-1.0, 1.0, 1.0, -1.0))
    order = (0, 2, 1, 3)  # the left ones first
    drive = DriveSettings(("a", "c"), ("b", "d"), 2 * y, radius, 1.0, 2 * y, radius)
    own = tuple(grips[i] for i in order)
    base = RollerBase.of(urdf, replace(drive, kind=DriveKind.MECANUM, grips=own))
    v, side, w = np.random.default_rng(seed).uniform(-1.0, 1.0, 3).tolist()
    velocity = Velocity(v, y=side, yaw_rate=w)
    assert base.reachable(velocity) is velocity
    # The formula of every textbook for an X of mecanum wheels: front left, front right, rear ...
    signs = ((-1.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0))
    expected = [(v + s * side + t * (x + y) * w) / radius for s, t in signs]
    speeds = base.speeds(velocity)
    assert speeds == pytest.approx([expected[i] for i in order])
    assert base.encoders(speeds) is speeds
    assert len(base.angles(velocity)) == 0
    assert base.motion(speeds * 0.1, base.angles(velocity)) == pytest.approx(
        (0.1 * v, 0.1 * side, 0.1 * w)
    )


def test_sides_turn_as_one_as_each_wheel_is_mounted() -> None:
    sides = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    base = SidesBase(0.5, 0.1, sides, sides / (2.0, 1.0))
    assert base.speeds(Velocity(1.0, yaw_rate=2.0)) == pytest.approx((5.0, -5.0, 15.0))
    assert base.encoders(np.array([1.0, -3.0, 4.0])) == pytest.approx((2.0, 4.0))
    assert base.motion(np.array([2.0, 4.0]), base.angles(Velocity())) == pytest.approx(
        (0.3, 0.0, 0.4)
    )
    behind = replace(base, axle=-0.2)  # the base swings to the left about wheels behind it
    assert behind.motion(np.array([2.0, 4.0]), np.zeros(0)) == pytest.approx((0.3, 0.08, 0.4))
    assert base.reachable(Velocity(1.0, y=3.0, yaw_rate=2.0)) == Velocity(1.0, yaw_rate=2.0)
    still = Velocity(1.0, yaw_rate=2.0)
    assert base.reachable(still) is still
    assert len(base.angles(still)) == 0


def test_wheels_of_unlike_sizes_roll_as_far_as_each_other() -> None:
    urdf = wheeled([(0.2, 0.25, -0.05), (-0.2, 0.25, 0.0), (0.2, -0.25, -0.05), (-0.2, -0.25, 0.0)])
    small = Part(Shape(Kind.CYLINDER, (0.05, 0.04)), ALONG_Y)
    links = {n: replace(urdf.links[n], collisions=(small,)) for n in ("a", "c")}
    drive = DriveSettings(("a", "b"), ("c", "d"), 0.5, 0.1, 1.0, 0.5, 0.1)
    robot = RobotModel(
        replace(urdf, links={**urdf.links, **links}), GazeboSettings(), drive, notes=()
    )
    base = SidesBase.of(robot, DriveConfig())
    speeds = base.speeds(Velocity(1.0, yaw_rate=2.0))
    assert speeds == pytest.approx((10.0, 5.0, 30.0, 15.0))  # 0.5 m/s left, 1.5 m/s right
    moved = base.motion(base.encoders(speeds), np.zeros(0))
    assert moved == pytest.approx((1.0, 0.0, 2.0), abs=1e-4)


WHEEL = SteeredWheel(np.array([1.0, 0.5]), np.array([1.0, 0.0]), 0.1, 0, np.array([1.0, 0.3]))


@pytest.mark.parametrize(
    ("angle", "position", "direction"),
    [
        (0.0, (1.0, 0.5), (1.0, 0.0)),
        (math.pi / 2, (0.8, 0.3), (0.0, 1.0)),
        (-math.pi / 2, (1.2, 0.3), (0.0, -1.0)),
    ],
)
def test_a_wheel_turns_about_its_pivot(
    angle: float, position: tuple[float, float], direction: tuple[float, float]
) -> None:
    found = WHEEL.turned(angle)
    assert found[0] == pytest.approx(position)
    assert found[1] == pytest.approx(direction, abs=1e-12)
