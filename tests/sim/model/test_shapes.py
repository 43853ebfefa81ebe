"""Points and faces of shapes by plain geometry."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from arjuna_sim.model.geometry.shapes import Group, Kind, Mesh, Shape, Terrain, circle, corners


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
    """MuJoCo's viewer draws groups 0 to 2 unless it is told otherwise."""
    numbers = {group.name: group.value for group in Group}
    assert sorted(numbers.values()) == [0, 1, 2, 3, 4]
    assert {name for name, value in numbers.items() if value > 2} == {
        *("ROBOT_COLLISION", "WORLD_CONTACT")
    }
