"""Positions and sizes of wheels, and how a robot turns on them, by plain geometry."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.model import wheels
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.urdf import Joint, Link, Mimic, Urdf
from tests.sim.wheeled import ALONG_Y, NAMES, TYRE, weight, wheeled


@pytest.mark.parametrize(("roll", "sign"), [(-math.pi / 2, 1.0), (math.pi / 2, -1.0)])
def test_a_wheel_rolls_ahead_or_back_by_where_its_axis_points(roll: float, sign: float) -> None:
    urdf = wheeled(along=(0.0, 0.0, 1.0), rpy=(roll, 0.0, 0.7))
    assert wheels.axis(urdf, "a") == pytest.approx(
        (-sign * math.sin(0.7), sign * math.cos(0.7), 0.0)
    )
    assert wheels.wheel_sign(urdf, "a") == sign
    # The top of a wheel goes the way of its axis crossed with up, and so does the robot.
    expected = np.cross(wheels.axis(urdf, "a"), (0.0, 0.0, 1.0))[:2]
    assert wheels.rolling_direction(urdf, "a") == pytest.approx(expected)
    tilted = wheeled(along=(0.0, 0.6, 0.8))
    assert wheels.rolling_direction(tilted, "a") == pytest.approx((1.0, 0.0))
    assert wheels.rolling_direction(wheeled(along=(0.0, 0.0, 1.0)), "a") == pytest.approx((0, 0))


def test_an_axis_may_lie_up_to_sixty_degrees_off_across() -> None:
    assert wheels.wheel_sign(wheeled(along=(math.sqrt(0.75), 0.5, 0.0)), "a") == 1.0
    assert wheels.wheel_sign(wheeled(along=(math.sqrt(0.75), -0.5, 0.0)), "a") == -1.0
    with pytest.raises(RobotError, match=r"must lie across the robot \(y\).*joint 'a'|'a'.*across"):
        wheels.wheel_sign(wheeled(along=(0.87, 0.499, 0.0)), "a")
    with pytest.raises(RobotError, match=r"\(y\) \(a joint without <axis> has x\), .*\(1, 0, 0\)"):
        wheels.wheel_sign(wheeled(along=(1.0, 0.0, 0.0)), "a")


def test_the_joint_that_steers_a_wheel_is_found_above_it() -> None:
    joints = (("left", "base", "arm"), ("right", "base", "other"), ("fork", "arm", "hub"))
    tree = (*joints, ("wheel", "hub", "tyre"), ("free", "base", "roller"))
    chain = {name: Joint(name, "revolute", up, down, Pose3()) for name, up, down in tree}
    urdf = Urdf(Path("r.urdf"), "r", "", "base", {}, chain)
    assert wheels.steered_by(urdf, "wheel", ("right", "left")) == 1
    assert wheels.steered_by(urdf, "wheel", ("fork", "left")) == 0  # the nearest
    assert wheels.steered_by(urdf, "free", ("right", "left")) == -1
    assert wheels.steered_by(urdf, "wheel", ("wheel",)) == -1  # not by itself


def test_a_wheel_is_as_large_as_its_shapes_about_its_axis() -> None:
    box = Part(Shape(Kind.BOX, (0.6, 0.3, 0.8)), Pose3((0.1, 0.2, 0.3)))
    urdf = wheeled(parts=(box,))
    assert wheels.radius_of(urdf, "a") == pytest.approx(0.5)  # half the diagonal of 0.6 by 0.8
    assert wheels.width_of(urdf, "a") == pytest.approx(0.3)
    assert wheels.eccentricity(urdf, "a") == pytest.approx(math.hypot(0.1, 0.3))
    assert not wheels.is_round(urdf, "a")
    assert wheels.center(urdf, "a") == pytest.approx((0.1, 0.2, 0.3))
    ball = Part(Shape(Kind.SPHERE, (0.07,)))
    assert wheels.radius_of(wheeled(parts=(ball, box)), "a") == 0.07  # what is round tells it
    assert wheels.radius_of(wheeled(parts=(ball, TYRE)), "a") == 0.1  # the largest
    assert wheels.wheel_radius(urdf, ("a",)) == wheels.radius_of(urdf, "a")
    assert wheels.wheel_radius(urdf, ()) == 0.0


def test_a_wheel_without_a_solid_shape_is_as_it_is_drawn_or_nothing() -> None:
    urdf = wheeled(parts=())
    assert (wheels.radius_of(urdf, "a"), wheels.width_of(urdf, "a")) == (0.0, 0.0)
    assert wheels.center(urdf, "a") == pytest.approx((0.0, 0.0, 0.0))
    drawn = Part(Shape(Kind.BOX, (0.6, 0.3, 0.8)))
    urdf.links["a"] = Link("a", None, (), (drawn,))
    assert wheels.radius_of(urdf, "a") == pytest.approx(0.5)
    assert wheels.width_of(urdf, "a") == pytest.approx(0.3)


@pytest.mark.parametrize(("off", "is_round"), [(0.0049, True), (0.0051, False)])
def test_a_wheel_that_is_nearly_round_is_centred_on_its_axis(off: float, is_round: bool) -> None:
    tyre = Part(TYRE.shape, Pose3((off, 0.02, 0.0), ALONG_Y.quaternion))
    urdf = wheeled([(1.0, 2.0, 3.0)], parts=(tyre,))
    assert wheels.is_round(urdf, "a") is is_round  # within a twentieth of 0.1 m
    assert wheels.center(urdf, "a") == pytest.approx((1.0 if is_round else 1.0 + off, 2.02, 3.0))


def test_sides_are_as_far_apart_as_their_wheels_are_on_the_mean() -> None:
    urdf = wheeled([(0.3, 0.2, 0.1), (-0.3, 0.4, 0.1), (0.0, -0.5, 0.1)])
    assert wheels.wheel_separation(urdf, ("a", "b"), ("c",)) == pytest.approx(0.8)
    assert wheels.wheel_separation(urdf, ("c",), ("a", "b")) == pytest.approx(0.8)
    assert wheels.span(urdf, ("a", "b", "c")) == pytest.approx(1.0)
    assert wheels.span(urdf, ("a",)) == pytest.approx(2.0 * math.hypot(0.3, 0.2))
    assert wheels.span(wheeled([(0.01, 0.0, 0.0)]), ("a",)) == 0.1  # no less than the radius


def least_power_track(
    positions: NDArray[np.float64], loads: NDArray[np.float64], left: int
) -> float:
    """Return 2 m/s of rims by the turn rate at which sliding takes the least power."""
    rims = np.where(np.arange(len(positions)) < left, -1.0, 1.0)
    x, y = positions.T

    def power(motion: NDArray[np.float64]) -> float:
        vx, vy, turn = motion
        return float(loads @ np.hypot(vx - turn * y - rims, vy + turn * x))

    options = {"xatol": 1e-7, "fatol": 1e-10, "maxiter": 3000}
    found = minimize(power, (0.0, 0.0, 1.0), method="Nelder-Mead", options=options)
    return 2.0 / float(found.x[2])


@pytest.mark.parametrize("seed", range(4))
def test_a_robot_turns_as_friction_takes_the_least_power(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sides = (1.0, 1.0, 1.0, -1.0, -1.0, -1.0)
    positions = np.column_stack((np.tile((0.4, 0.0, -0.4), 2), sides)) * (1.0, 0.3)
    positions += rng.uniform(-0.1, 0.1, (6, 2))
    center = (float(rng.uniform(-0.3, 0.3)), float(rng.uniform(-0.1, 0.1)), 0.2)
    urdf = wheeled(
        [(*p, 0.0) for p in positions.tolist()], base=weight(0.6, center), wheel=weight(0.05)
    )
    middle = (0.6 * np.array(center[:2]) + 0.05 * positions.sum(axis=0)) / 0.9
    # As of a rigid body on equal springs, the loads grow evenly along the ground.
    levers = np.column_stack((np.ones(6), positions))
    loads = np.maximum(levers @ np.linalg.solve(levers.T @ levers, [1.0, *middle]), 0.0)
    expected = least_power_track(positions, loads, 3)
    assert wheels.effective_track(urdf, NAMES[:3], NAMES[3:]) == pytest.approx(expected, rel=2e-3)


def test_four_equal_wheels_turn_as_the_formula_says_and_two_as_they_stand() -> None:
    corners = [(x, y, 0.0) for y in (0.3, -0.3) for x in (0.2, -0.2)]
    left, right = NAMES[:2], NAMES[2:4]
    for base in (None, weight(0.0), weight(5.0, (0.0, 0.0, 1.0))):
        urdf = wheeled(corners, base=base)
        expected = 0.6 * (1.0 + (0.4 / 0.6) ** 2)
        assert wheels.effective_track(urdf, left, right) == pytest.approx(expected, rel=1e-3)
    nose = wheeled(corners, base=weight(5.0, (0.9, 0.0, 0.0)))  # lifts the wheels behind
    assert wheels.effective_track(nose, left, right) == pytest.approx(0.6, rel=1e-3)
    pair = wheeled([(0.1, 0.3, 0.0), (0.1, -0.3, 0.0)], base=weight(5.0))
    assert wheels.effective_track(pair, ("a",), ("b",)) == pytest.approx(0.6)
    assert wheels.effective_track(pair, ("b",), ("a",)) == pytest.approx(0.6)  # sides confused
    assert wheels.effective_track(wheeled([(1, 0, 0), (-1, 0, 0)]), ("a",), ("b",)) == 0.0
    wide = wheeled([(0.0, 0.5, 0.0), (0.0, -0.5, 0.0)])
    assert wheels.effective_track(wide, ("a",), ("b",)) == pytest.approx(1.0)


def test_what_led_a_wheel_with_a_motor_follows_it() -> None:
    urdf = wheeled([(0.0, 0.1, 0.0), (0.0, -0.1, 0.0)])
    joints = dict(urdf.joints)
    joints["a"] = replace(joints["a"], mimic=Mimic("b", 2.0, 0.5))
    joints["b"] = replace(joints["b"], damping=3.0, friction=4.0)
    freed = wheels.freed(replace(urdf, joints=joints), ("a",)).joints
    assert (freed["a"].mimic, freed["b"].mimic) == (None, Mimic("a", 0.5, -0.25))
    assert (freed["b"].damping, freed["b"].friction) == (0.0, 0.0)
    both = wheels.freed(replace(urdf, joints=joints), ("a", "b")).joints
    assert (both["a"].mimic, both["b"]) == (None, joints["b"])
