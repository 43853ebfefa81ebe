"""Where planes cut shapes, what shapes weigh, and the boxes around them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import (
    DENSITY,
    Group,
    Kind,
    Mesh,
    Part,
    Shape,
    Terrain,
    estimated_inertial,
    inertial_of_parts,
    volume_of,
)
from arjuna_sim.model.geometry.walls import surfaces
from arjuna_sim.model.world import Body, World

ASKEW = Pose3.from_rpy((1.0, -2.0, 0.4), (0.4, -0.3, 1.1))
BALL, EGG = Shape(Kind.SPHERE, (0.5,)), Shape(Kind.ELLIPSOID, (0.7, 0.4, 0.3))
BOX, TUBE = Shape(Kind.BOX, (0.4, 0.6, 1.0)), Shape(Kind.CYLINDER, (0.3, 0.8))
PILL = Shape(Kind.CAPSULE, (0.2, 0.6))
HILL = Terrain(Path("hill.png"), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))


def brick(low: tuple[float, ...], high: tuple[float, ...]) -> Mesh:
    """Return a mesh whose faces reach the eight corners of a box."""
    a, b = np.array(low), np.array(high)
    corners = np.array([np.where([i & 1, i & 2, i & 4], b, a) for i in range(8)])
    faces = [[0, 1, 3], [4, 5, 7], [0, 2, 6], [1, 5, 7], [2, 4, 6]]
    return Mesh(Path("brick.stl"), corners[faces])


def cut(shape: Shape, pose: Pose3, height: float, collides: bool = True) -> NDArray[np.float64]:
    """Return the lines in which a plane cuts a world of one shape."""
    body = Body("m", Part(shape, pose), collides)
    return surfaces(World(Path("w.world"), "w", (body,), ()), height)


def filled(shape: Shape, pose: Pose3) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return volume, centre and inertia per mass of a shape filled with grains."""
    axes = np.meshgrid(*[np.linspace(-1.0, 1.0, 61)[:-1] + 1.0 / 60] * 3)
    grains = np.stack(axes, axis=-1).reshape(-1, 3)
    x, y, z = grains.T
    size = shape.size
    inside = {
        Kind.SPHERE: lambda: np.hypot(np.hypot(x, y), z) <= size[0],
        Kind.ELLIPSOID: lambda: (grains**2 / np.array(size) ** 2).sum(axis=1) <= 1.0,
        Kind.BOX: lambda: (np.abs(grains) <= np.array(size) / 2).all(axis=1),
        Kind.CYLINDER: lambda: (np.hypot(x, y) <= size[0]) & (np.abs(z) <= size[1] / 2),
    }[shape.kind]()
    points = pose.apply(grains[inside])
    arms = points - points.mean(axis=0)
    inertia = (arms**2).sum(axis=1).mean() * np.eye(3) - arms.T @ arms / len(arms)
    return len(points) / 30**3, points.mean(axis=0), inertia


@pytest.mark.parametrize("shape", [BALL, EGG, BOX, TUBE], ids=lambda shape: shape.kind.value)
def test_a_shape_weighs_and_turns_as_if_it_were_filled(shape: Shape) -> None:
    volume, center, inertia = filled(shape, ASKEW)
    found = inertial_of_parts([Part(shape, ASKEW)], 3.0)
    assert volume_of([Part(shape)]) == pytest.approx(volume, rel=0.02)
    assert found.mass == 3.0
    assert found.center == pytest.approx(center, abs=2e-3)
    np.testing.assert_allclose(found.inertia, 3.0 * inertia, atol=4e-3)


def test_parts_of_a_link_share_its_mass_by_volume() -> None:
    left, right = Part(Shape(Kind.BOX, (1.0, 1.0, 2.0))), Shape(Kind.BOX, (1.0, 1.0, 1.0))
    found = inertial_of_parts([left, Part(right, Pose3((3.0, 0.0, 0.0)))], 6.0)
    assert found.center == pytest.approx((1.0, 0.0, 0.0))
    own = (4.0 * 2.0 + 2.0 * 2.0) / 12.0  # of both about x, the line through both centres
    assert found.inertia[0, 0] == pytest.approx(4.0 * 5.0 / 12.0 + 2.0 * 2.0 / 12.0)
    assert found.inertia[2, 2] == pytest.approx(own + 4.0 * 1.0 + 2.0 * 4.0)


def test_a_link_without_mass_is_half_as_heavy_as_water_and_one_without_shape_has_none() -> None:
    found = estimated_inertial([Part(BOX), Part(PILL)])
    pill = math.pi * 0.2**2 * 0.6 + 4.0 / 3.0 * math.pi * 0.2**3
    assert found is not None
    assert found.mass == pytest.approx(DENSITY * (0.4 * 0.6 * 1.0 + pill))
    assert estimated_inertial([Part(Shape(Kind.PLANE))]) is None
    ball = inertial_of_parts([], 2.0)
    assert ball.center == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(ball.inertia, np.eye(3) * 0.4 * 2.0 * 0.05**2)


def test_a_mesh_weighs_as_its_hull_about_the_middle_of_its_box() -> None:
    shape = Shape(Kind.MESH, (2.0, 1.0, 1.0), brick((1.0, 0.0, 0.0), (2.0, 1.0, 3.0)))
    assert volume_of([Part(shape)]) == pytest.approx(6.0)
    found = inertial_of_parts([Part(shape, Pose3((0.0, 10.0, 0.0)))], 12.0)
    assert found.center == pytest.approx((3.0, 10.5, 1.5))
    assert np.diag(found.inertia) == pytest.approx([10.0, 13.0, 5.0])
    flat = Shape(Kind.MESH, (1.0, 1.0, 1.0), brick((0.0, 0.0, 0.0), (2.0, 1.0, 0.0)))
    assert volume_of([Part(flat)]) == pytest.approx(2.0 * 1e-3)  # a sheet is a millimetre thick


@pytest.mark.parametrize("shape", [BALL, EGG], ids=lambda shape: shape.kind.value)
@pytest.mark.parametrize("height", [0.4, 0.55, 0.2])
def test_a_plane_cuts_a_round_shape_in_one_closed_line_on_its_surface(
    shape: Shape, height: float
) -> None:
    lines = cut(shape, ASKEW, height)
    np.testing.assert_array_equal(lines[:, 2:], np.roll(lines[:, :2], -1, axis=0))
    ends = np.column_stack((lines[:, :2], np.full(len(lines), height)))
    own = ASKEW.inverse().apply(ends) / np.array(shape.size)
    np.testing.assert_allclose(np.linalg.norm(own, axis=1), 1.0, atol=1e-9)
    assert len(cut(shape, ASKEW, 0.4 + 0.71)) == len(cut(shape, ASKEW, 0.4 - 0.71)) == 0
    assert len(cut(shape, ASKEW, height, collides=False)) == 0


def test_a_ball_is_cut_in_a_circle_as_wide_as_geometry_says() -> None:
    lines = cut(BALL, Pose3((3.0, 1.0, 0.3)), 0.6)
    np.testing.assert_allclose(np.hypot(lines[:, 0] - 3.0, lines[:, 1] - 1.0), 0.4)
    assert np.ptp(lines[:, 0]) == pytest.approx(0.8, rel=0.01)


def test_a_hill_is_cut_where_it_is_as_high_as_the_plane() -> None:
    shape = Shape(Kind.TERRAIN, (4.0, 2.0, 3.0), terrain=HILL)
    lines = cut(shape, Pose3((10.0, 0.0, 1.0)), 2.5)  # halfway up
    ends = lines.reshape(-1, 2)
    assert ends.min(axis=0) == pytest.approx([9.0, -0.5])
    assert ends.max(axis=0) == pytest.approx([11.0, 0.5])
    assert len(cut(shape, Pose3((10.0, 0.0, 1.0)), 4.1)) == 0


@pytest.mark.parametrize(
    ("shape", "reach"),
    [
        (BALL, (0.5, 0.5, 0.5)),
        (EGG, (0.7, 0.4, 0.3)),
        (BOX, (0.2, 0.3, 0.5)),
        (TUBE, (0.3, 0.3, 0.4)),
        (PILL, (0.2, 0.2, 0.5)),
        (Shape(Kind.TERRAIN, (4.0, 2.0, 3.0), terrain=HILL), (2.0, 1.0, 3.0)),
        (Shape(Kind.PLANE), (0.0, 0.0, 0.0)),
    ],
    ids=lambda case: case.kind.value if isinstance(case, Shape) else "",
)
def test_the_box_around_a_shape_is_as_large_as_it(
    shape: Shape, reach: tuple[float, float, float]
) -> None:
    low, high = Entity("e", (Part(shape, Pose3((5.0, 0.0, 0.0))),)).bounds()
    offset = np.array((5.0 if any(reach) else 0.0, 0.0, 0.0))
    np.testing.assert_allclose(high - offset, reach, atol=1e-9)
    below = (*reach[:2], 0.0) if shape.kind is Kind.TERRAIN else reach
    np.testing.assert_allclose(low - offset, -np.array(below), atol=1e-9)


def test_a_capsule_is_round_at_its_ends() -> None:
    lines = cut(PILL, Pose3(), 0.3 + 0.2 * math.sin(math.pi / 4))
    assert np.hypot(lines[:, 0], lines[:, 1]).max() == pytest.approx(0.2 * math.cos(math.pi / 4))


def test_what_can_be_pushed_is_lifted_out_of_the_ground_and_what_is_fixed_stays() -> None:
    tilted = Pose3.from_rpy((1.0, 2.0, 0.1), (math.pi / 2, 0.0, 0.0))
    crate = Entity("crate", (Part(BOX),), mass=5.0)
    assert crate.lifted(tilted).position == pytest.approx((1.0, 2.0, 0.3))
    assert crate.lifted(tilted).quaternion == tilted.quaternion
    above = Pose3((0.0, 0.0, 0.5))
    assert crate.lifted(above) is above
    assert Entity("pillar", (Part(BOX),)).lifted(tilted) is tilted
    assert Entity("picture", (), (Part(BOX),), mass=5.0).lifted(tilted) != tilted


def test_every_group_has_a_number_of_its_own_among_mujocos_six() -> None:
    assert len(Group) == len(Group.__members__)  # members of one number are one
    assert all(0 <= group.value < 6 for group in Group)
