"""Shapes: their corners and triangles, masses, outlines and sections."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import (
    DENSITY,
    Group,
    Kind,
    Mesh,
    Part,
    Shape,
    Terrain,
    circle,
    corners,
    estimated_inertial,
    inertial_of_parts,
    volume_of,
)
from arjuna_sim.model.geometry.walls import surfaces
from arjuna_sim.model.world import Body, World


def test_a_circle_has_64_corners_that_begin_ahead_and_go_left() -> None:
    ring = circle(2.0)
    assert ring.shape == (64, 2)
    assert ring[0] == pytest.approx((2.0, 0.0))
    assert ring[16] == pytest.approx((0.0, 2.0))
    assert np.linalg.norm(ring, axis=1) == pytest.approx(2.0)
    gaps = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    assert gaps == pytest.approx(4.0 * math.sin(math.pi / 64))


RING = 32 * math.sin(math.pi / 32)  # area of a regular 64-gon of radius 1
RISE = [(math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(5)]


def capsule(radius: float, length: float) -> float:
    """Return the volume of a 64-gon's column and, at each end, of four frusta."""
    ends = sum(
        (s1 - s0) / 3.0 * (c0 * c0 + c0 * c1 + c1 * c1) for (c0, s0), (c1, s1) in pairwise(RISE)
    )
    return RING * (radius**2 * length + 2.0 * radius**3 * ends)


@pytest.mark.parametrize(
    ("shape", "volume", "reach"),
    [
        (Shape(Kind.BOX, (1.0, 2.0, 3.0)), 6.0, (0.5, 1.0, 1.5)),
        (Shape(Kind.SPHERE, (0.5,)), 1.0, (0.5, 0.5, 0.5)),
        (Shape(Kind.ELLIPSOID, (0.5, 1.0, 1.5)), 6.0, (0.5, 1.0, 1.5)),
        (Shape(Kind.CYLINDER, (0.5, 2.0)), RING * 0.25 * 2.0, (0.5, 0.5, 1.0)),
        (Shape(Kind.CAPSULE, (0.5, 2.0)), capsule(0.5, 2.0), (0.5, 0.5, 1.5)),
    ],
    ids=lambda value: value.kind.value if isinstance(value, Shape) else "",
)
def test_corners_enclose_a_shape(shape: Shape, volume: float, reach: tuple[float, ...]) -> None:
    points = corners(shape)
    assert ConvexHull(points).volume == pytest.approx(volume)
    assert points.max(axis=0) == pytest.approx(reach)
    assert points.min(axis=0) == pytest.approx([-value for value in reach])


def test_a_plane_has_no_corners() -> None:
    assert corners(Shape(Kind.PLANE)).shape == (0, 3)


HILL = Terrain(Path("t.png"), np.array([[0.0, 0.5, 1.0], [0.25, 0.75, 0.5]]))


def test_a_terrain_spans_its_extent_row_by_row() -> None:
    points = HILL.points((4.0, 2.0, 8.0))
    assert points.shape == (2, 3, 3)
    assert points[0].tolist() == [[-2.0, -1.0, 0.0], [0.0, -1.0, 4.0], [2.0, -1.0, 8.0]]
    assert points[1].tolist() == [[-2.0, 1.0, 2.0], [0.0, 1.0, 6.0], [2.0, 1.0, 4.0]]
    shape = Shape(Kind.TERRAIN, (4.0, 2.0, 8.0), terrain=HILL)
    np.testing.assert_array_equal(corners(shape), points.reshape(-1, 3))


def test_a_terrains_faces_cover_it_once_and_face_up() -> None:
    faces = Shape(Kind.TERRAIN, (4.0, 2.0, 8.0), terrain=HILL).triangles()
    assert faces is not None
    assert faces.shape == (4, 3, 3)
    up = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])[:, 2] / 2.0
    assert up == pytest.approx([2.0] * 4)  # half of each cell of 2 m by 2 m
    edges = {
        frozenset(map(tuple, np.delete(face, i, axis=0).tolist()))
        for face in faces
        for i in range(3)
    }
    assert len(edges) == 3 * 4 - 3  # of which three are shared


def test_a_mesh_is_scaled_and_reaches_as_far_as_its_farthest_number() -> None:
    mesh = Mesh(Path("m.stl"), np.array([[[1.0, 2.0, -5.0], [0.0, 1.0, 0.0], [3.0, 0.0, 1.0]]]))
    assert mesh.reach == 5.0
    found = Shape(Kind.MESH, (2.0, 1.0, -1.0), mesh).triangles()
    assert found is not None
    assert found.tolist() == [[[2.0, 2.0, 5.0], [0.0, 1.0, 0.0], [6.0, 0.0, -1.0]]]
    assert Shape(Kind.BOX, (1.0, 1.0, 1.0)).triangles() is None
    assert mesh.hull((1.0, 1.0, 1.0)) is mesh.hull((1.0, 1.0, 1.0))
    assert mesh.hull((1.0, 2.0, 1.0))[:, 1].max() == pytest.approx(4.0, abs=1e-2)
    one, other = mesh.pieces((1.0, 1.0, 1.0), 5), mesh.pieces((1.0, 1.0, 1.0), 6)
    assert mesh.pieces((1.0, 1.0, 1.0), 5) is one
    assert one is not other


def test_groups_are_mujocos_numbers_of_which_the_first_three_are_drawn() -> None:
    """MuJoCo's viewer draws groups 0 to 2 by default."""
    numbers = {group.name: group.value for group in Group}
    assert sorted(numbers.values()) == [0, 1, 2, 3, 4]
    assert {name for name, value in numbers.items() if value > 2} == {
        *("ROBOT_COLLISION", "WORLD_CONTACT")
    }


ASKEW = Pose3.from_rpy((1.0, -2.0, 0.4), (0.4, -0.3, 1.1))
BALL, EGG = Shape(Kind.SPHERE, (0.5,)), Shape(Kind.ELLIPSOID, (0.7, 0.4, 0.3))
BOX, TUBE = Shape(Kind.BOX, (0.4, 0.6, 1.0)), Shape(Kind.CYLINDER, (0.3, 0.8))
PILL = Shape(Kind.CAPSULE, (0.2, 0.6))
HILL_1 = Terrain(Path("hill.png"), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))


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
    dust = estimated_inertial([Part(Shape(Kind.BOX, (1e-4, 1e-4, 1e-4)))])
    assert dust is not None
    assert dust.mass == 1e-6
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
def test_a_plane_cuts_a_round_shape_in_one_closed_line(shape: Shape, height: float) -> None:
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
    shape = Shape(Kind.TERRAIN, (4.0, 2.0, 3.0), terrain=HILL_1)
    lines = cut(shape, Pose3((10.0, 0.0, 1.0)), 2.5)  # halfway up
    ends = lines.reshape(-1, 2)
    assert ends.min(axis=0) == pytest.approx([9.0, -0.5])
    assert ends.max(axis=0) == pytest.approx([11.0, 0.5])
    assert len(cut(shape, Pose3((10.0, 0.0, 1.0)), 4.1)) == 0


def test_a_capsule_is_round_at_its_ends() -> None:
    lines = cut(PILL, Pose3(), 0.3 + 0.2 * math.sin(math.pi / 4))
    assert np.hypot(lines[:, 0], lines[:, 1]).max() == pytest.approx(0.2 * math.cos(math.pi / 4))
