"""Tyres rest, sink in and bounce as the masses and springs that they stand for."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import Inertial, Kind, Mesh, Part, Shape, corners
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Link
from arjuna_sim.physics.robot_body import add_robot
from arjuna_sim.physics.wheels.servo import ServoConfig
from arjuna_sim.physics.wheels.tyres import STICTION, WheelSupport, sag_of, tune_tyres
from tests.sim.wheeled import ALONG_Y, TYRE, wheeled

FOUR = ((0.2, 0.3, 0.0), (0.2, -0.3, 0.0), (-0.2, 0.3, 0.0), (-0.2, -0.3, 0.0))
DRIVE = DriveSettings(("a", "c"), ("b", "d"), 0.6, 0.1, 5.0, 0.6, 0.1)
SAG, STEP = 0.0008, 0.002  # of wheels of 0.1 m
BODY = Inertial(8.0, (0.0, 0.0, 0.05), np.diag([0.2, 0.3, 0.4]))
WHEEL = Inertial(0.5, (0.0, 0.0, 0.0), np.diag([0.002, 0.003, 0.002]))
MASS = 8.0 + 4 * 0.5


def robot(*below: Part, friction: dict[str, float] | None = None, **drive: Any) -> RobotModel:
    """Return a body on four wheels of 0.1 m, with shapes of its own."""
    urdf = wheeled(FOUR, wheel=WHEEL)
    urdf.links["base"] = Link("base", BODY, below, ())
    settings = GazeboSettings(friction=friction or {})
    return RobotModel(urdf, settings, replace(DRIVE, **drive), ())


def compiled(one: RobotModel, timestep: float = STEP) -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = timestep
    add_robot(spec, one, ServoConfig(), sag_of(one, timestep))
    return spec.compile()


def tuned(one: RobotModel, timestep: float = STEP) -> tuple[Any, WheelSupport]:
    model = compiled(one, timestep)
    return model, tune_tyres(model, one, sag_of(one, timestep))


def spring_and_damper(model: Any, geom: int) -> tuple[float, float, float]:
    """Return the spring and damper that MuJoCo documents for a contact's numbers.

    With solref = (-stiffness, -damping) it asks for the acceleration -b v - k r with b = damping /
    d and k = stiffness / d, d the impedance, and yields by R = (1 - d) / d A, A the inverse mass
    of the body; so the contact is a spring k / R and a damper b / R.

    Returns:
        The spring [N/m], the damper [N s/m] and b [1/s].
    """
    stiffness, damping = -model.geom_solref[geom]
    least, most = model.geom_solimp[geom, :2]
    assert least == most
    inverse = model.body_invweight0[model.geom_bodyid[geom], 0]
    gives = (1.0 - most) / most * inverse
    return stiffness / most / gives, damping / most / gives, damping / most


def geom(model: Any, name: str) -> int:
    return int(model.geom(name).id)


@pytest.mark.parametrize(("radius", "timestep"), [(0.1, 0.002), (0.02, 0.005), (0.2, 0.001)])
def test_a_tyre_sinks_in_by_its_radius_or_fall(radius: float, timestep: float) -> None:
    expected = max(radius / 125.0, 4.0 * 9.81 * timestep**2)
    assert sag_of(robot(radius=radius), timestep) == pytest.approx(expected)


@pytest.mark.parametrize(("timestep", "rate"), [(0.002, 50.0), (0.001, 50.0), (0.02, 25.0)])
def test_a_tyre_carries_its_share_and_bounces_lightly(timestep: float, rate: float) -> None:
    one = robot()
    model, standing = tuned(one, timestep)
    sag, load = sag_of(one, timestep), MASS / 4
    assert len(standing.tyres) == 4
    for tyre in standing.tyres:
        spring, damper, b = spring_and_damper(model, tyre)
        assert spring * sag == pytest.approx(load * 9.81)
        assert damper == pytest.approx(0.005 * 2.0 * math.sqrt(spring * load))
        assert b == pytest.approx(rate)
    assert STICTION == 1e6


def test_tyres_are_round_and_crowned_on_rims_that_are_smaller() -> None:
    model, standing = tuned(robot())
    names = [model.geom(tyre).name for tyre in standing.tyres]
    assert names == [f"{name}//tyre" for name in "abcd"]
    assert standing.tyres == tuple(sorted(standing.tyres))
    tyre, rim = model.geom("a//tyre"), model.geom("a//rim")
    assert tyre.type[0] == mujoco.mjtGeom.mjGEOM_ELLIPSOID
    assert tyre.size == pytest.approx((0.1 + SAG / 2, 0.1 + SAG / 2, 0.02))
    assert rim.type[0] == mujoco.mjtGeom.mjGEOM_CYLINDER
    assert rim.size[:2] == pytest.approx((0.1 - 2.0 * SAG, 0.02))
    for each in (tyre, rim):
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, each.quat)
        assert np.abs(turned.reshape(3, 3)[:, 2]) == pytest.approx((0.0, 1.0, 0.0))
        assert (each.contype[0], each.conaffinity[0], each.group[0]) == (0, 1, 3)
    assert model.body_mass.sum() == pytest.approx(MASS)


def test_the_rim_of_a_ball_is_a_ball_on_which_it_may_lean() -> None:
    one = robot()
    one.urdf.links["a"] = Link("a", WHEEL, (Part(Shape(Kind.SPHERE, (0.1,))),), ())
    rim = compiled(one).geom("a//rim")
    assert rim.type[0] == mujoco.mjtGeom.mjGEOM_SPHERE
    assert rim.size[0] == pytest.approx(0.1 - 2.0 * SAG)


def test_a_tyre_is_where_its_wheels_shape_is_with_its_friction() -> None:
    one = robot(friction={"b": 0.3})
    aside = Part(TYRE.shape, Pose3((0.0, 0.05, 0.0)) @ ALONG_Y)
    one.urdf.links["a"] = Link("a", WHEEL, (aside,), ())
    model = compiled(one)
    assert model.geom("a//tyre").pos == pytest.approx((0.0, 0.05, 0.0))
    assert model.geom("c//tyre").pos == pytest.approx((0.0, 0.0, 0.0))
    assert model.geom("b//tyre").friction[0] == model.geom("b//rim").friction[0] == 0.3
    assert model.geom("a//tyre").friction[0] == 1.0  # MuJoCo's own


TILT = Pose3.from_rpy((0.05, 0.02, -0.1), (0.3, -0.5, 0.7))
CONTACTS = [
    Shape(Kind.SPHERE, (0.12,)),
    Shape(Kind.BOX, (0.2, 0.3, 0.25)),
    Shape(Kind.CYLINDER, (0.07, 0.25)),
    Shape(Kind.ELLIPSOID, (0.1, 0.2, 0.12)),
    Shape(
        Kind.MESH,
        (0.1, 0.1, 0.1),
        Mesh(Path("m.stl"), np.random.default_rng(3).uniform(-1.5, 1.5, (30, 3, 3))),
    ),
]


def lowest(shape: Shape, pose: Pose3) -> float:
    """Return how low a shape reaches, by many points of its surface."""
    if shape.kind in (Kind.BOX, Kind.MESH):
        return float(pose.apply(corners(shape))[:, 2].min())
    if shape.kind is Kind.CYLINDER:  # its rims, at a ten-thousandth of a circle
        angles = np.linspace(0.0, 2.0 * math.pi, 10_001)
        ring = shape.size[0] * np.stack((np.cos(angles), np.sin(angles), 0.0 * angles), 1)
        half = np.array((0.0, 0.0, shape.size[1] / 2))
        return float(pose.apply(np.vstack((ring - half, ring + half)))[:, 2].min())
    directions = np.random.default_rng(0).normal(size=(200_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    radii = np.array(shape.size * 3 if shape.kind is Kind.SPHERE else shape.size)
    return float(pose.apply(directions * radii)[:, 2].min())


@pytest.mark.parametrize("shape", CONTACTS, ids=lambda shape: shape.kind.value)
def test_a_robot_stands_on_its_lowest_shape(shape: Shape) -> None:
    assert tuned(robot())[1].ride_height == pytest.approx(0.1 + SAG / 2 - SAG)
    found = tuned(robot(Part(shape, TILT)))[1]
    assert found.ride_height == pytest.approx(-lowest(shape, TILT), abs=1e-4)


def ball(z: float, x: float = 0.0, radius: float = 0.02) -> Part:
    """Return a ball that reaches down to a height above the wheels' lowest points."""
    return Part(Shape(Kind.SPHERE, (radius,)), Pose3((x, 0.0, z - 0.1 - SAG / 2 + radius)))


def own(model: Any) -> list[int]:
    """Return the geoms of the body's own shapes."""
    body = model.body("body:base").id
    return [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]


@pytest.mark.parametrize(("z", "touches"), [(0.0079, True), (0.0081, False), (-0.03, True)])
@pytest.mark.parametrize(
    ("rubs", "share"), [(0.01, 0.7), (0.03, 0.7), (0.1, 0.3), (1.5, 0.02), (0.0, 0.7)]
)
def test_a_sliding_caster_is_damped(z: float, touches: bool, rubs: float, share: float) -> None:
    model = compiled(one := robot(ball(z), friction={"base": rubs}))
    before = model.geom_solref.copy()
    tune_tyres(model, one, SAG)
    (caster,) = own(model)
    if not touches:
        np.testing.assert_array_equal(model.geom_solref[caster], before[caster])
        return
    spring, damper, b = spring_and_damper(model, caster)
    load = MASS / 4
    assert spring * SAG == pytest.approx(load * 9.81, rel=1e-3)
    assert damper == pytest.approx(share * 2.0 * math.sqrt(spring * load), rel=1e-3)
    assert b == pytest.approx(50.0)


@pytest.mark.parametrize(("tilt", "crowned"), [(0.0, True), (0.099, True), (0.101, False)])
def test_a_roller_that_lies_is_crowned(tilt: float, crowned: bool) -> None:
    roller = Shape(Kind.CYLINDER, (0.03, 0.02))
    pose = Pose3.from_rpy((0.0, 0.0, -0.0704), (math.pi / 2 + math.asin(tilt), 0.0, 0.0))
    model, _ = tuned(robot(Part(roller, pose)))
    (caster,) = own(model)
    kinds = {True: mujoco.mjtGeom.mjGEOM_ELLIPSOID, False: mujoco.mjtGeom.mjGEOM_CYLINDER}
    assert model.geom_type[caster] == kinds[crowned]
    expected = (0.03, 0.03, 0.01) if crowned else (0.03, 0.01)
    assert model.geom_size[caster][: len(expected)] == pytest.approx(expected)


def test_it_pulls_away_as_its_motors_let_it() -> None:
    """Four wheels of 0.4 N m and 0.1 m push 10 kg and what their turning adds, I / r^2 each."""
    spin = tuned(robot(friction=dict.fromkeys("abcd", 9.0), torque=0.4))[1].steady
    model = compiled(robot())
    inertia = sum(float(model.dof_M0[model.joint(n).dofadr[0]]) for n in "abcd")
    assert inertia > 4 * 0.003
    assert spin == pytest.approx(0.8 * 4 * 0.4 / 0.1 / (MASS + inertia / 0.1**2))


def test_it_leans_by_how_high_its_weight_is() -> None:
    """A weight h above the ground lifts the front wheels at a = g l / h, l of them behind it."""
    low = tuned(robot(friction=dict.fromkeys("abcd", 9.0), torque=900.0))[1].steady
    model = compiled(robot())
    inertia = sum(float(model.dof_M0[model.joint(n).dofadr[0]]) for n in "abcd")
    height = (8.0 * 0.05) / MASS + 0.1 + SAG / 2
    # The wheels' own spin, I a / r, leans as well.
    expected = MASS * 9.81 * 0.2 / (MASS * height + inertia / 0.1)
    assert low == pytest.approx(expected)


@pytest.mark.parametrize("free", [("a", "b"), ()])
def test_wheels_that_nothing_drives_neither_pull_nor_brake(free: tuple[str, ...]) -> None:
    all_four = tuned(robot(friction=dict.fromkeys("abcd", 0.5), torque=900.0))[1].steady
    rear = {"left": ("c",), "right": ("d",), "free": free, "torque": 900.0}
    half = tuned(robot(friction=dict.fromkeys("abcd", 0.5), **rear))[1].steady
    assert all_four == pytest.approx(0.8 * 0.5 * 9.81)
    assert half == pytest.approx(0.8 * 0.5 * 9.81 / 2)


def test_a_flat_foot_stands_in_the_middle_of_its_underside() -> None:
    """A box of a mesh behind two driven wheels carries a third of a weight two thirds ahead."""
    block = np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (0.0, 0.04)])
    tip = np.vstack((block, [(0.0, 0.3, 0.1)]))  # what is higher does not matter
    faces = tip[np.array([(i, j, 8) for i in range(8) for j in range(8) if i != j])]
    mesh = Shape(Kind.MESH, (1.0, 1.0, 1.0), Mesh(Path("f.stl"), faces))
    two = {"left": ("a",), "right": ("b",), "free": (), "torque": 900.0}
    rubs = {"base": 0.0, "a": 0.5, "b": 0.5}
    one = robot(Part(mesh, Pose3((-0.4, 0.0, -0.1 - SAG / 2))), friction=rubs, **two)
    positions = one.urdf.joints
    for name in "cd":
        positions[name] = replace(positions[name], T_parent_child=Pose3((0.0, 0.1, 0.5)))
    model, standing = tuned(one)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    x = float(data.subtree_com[model.body("body:base").id][0])
    carried = (x + 0.4) / 0.6  # by the wheels at x = 0.2, the foot at x = -0.4
    assert standing.steady == pytest.approx(max(0.5, 0.8 * 0.5 * 9.81 * carried), rel=0.02)
