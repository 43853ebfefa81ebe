"""Shapes are touched as they are seen; walls are closed."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.solids import prism
from arjuna_sim.model.geometry.shapes import Group, Kind, Mesh, Part, Shape
from arjuna_sim.model.geometry.walls import enclosure_of
from arjuna_sim.physics.geoms import add_part

SEEDS = range(8)
RADIUS = 0.02  # of the sphere that feels [m]
WITHIN = 2e-3  # [m]

Faces = NDArray[np.float64]
Chance = np.random.Generator


def box(edges: Faces) -> Faces:
    half = edges[:2] / 2
    outline = half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return prism(outline, float(edges[2]))


def plate(rng: Chance) -> Faces:
    return box(np.append(rng.uniform(0.2, 2.0, 2), rng.uniform(5e-4, 5e-3)))


def letter_l(rng: Chance) -> Faces:
    a, b, t = (*rng.uniform(0.3, 1.0, 2), rng.uniform(2e-3, 0.1))
    return prism(np.array([(0, 0), (a, 0), (a, t), (t, t), (t, b), (0, b)]), rng.uniform(0.1, 1.0))


def wedge(rng: Chance) -> Faces:
    a, b = rng.uniform(0.05, 1.0, 2)
    return prism(np.array([(0, 0), (a, 0), (a, b), (a / 2, b / 4)]), rng.uniform(0.1, 1.0))


def ring(rng: Chance) -> Faces:
    inner = rng.uniform(0.1, 0.5)
    made = trimesh.creation.annulus(inner, inner + rng.uniform(1e-3, 0.2), 0.3, sections=24)
    return np.asarray(made.triangles, np.float64)


def inside_out(rng: Chance) -> Faces:
    return letter_l(rng)[:, ::-1]


def half_turned(rng: Chance) -> Faces:
    faces = letter_l(rng)
    turned = rng.random(len(faces)) < 0.5
    return np.where(turned[:, None, None], faces[:, ::-1], faces)


def bin_without_lid(rng: Chance) -> Faces:
    faces = box(rng.uniform(0.2, 1.0, 3))
    is_lid = faces[:, :, 2].min(axis=1) == faces[:, :, 2].max()
    return np.asarray(faces[~is_lid])


def cut_open(rng: Chance) -> Faces:
    faces = letter_l(rng)
    return faces[rng.permutation(len(faces))[: len(faces) // 2]]


@pytest.mark.parametrize(
    "form", [plate, letter_l, wedge, ring, inside_out, half_turned, bin_without_lid, cut_open]
)
def test_a_sphere_touches_what_a_ray_sees(form: Callable[[Chance], Faces]) -> None:
    worst = [apart(form(rng), rng) for rng in map(np.random.default_rng, SEEDS)]
    assert max(worst) <= WITHIN


def apart(faces: Faces, rng: Chance) -> float:
    """Return by how much the sphere's distances from pieces and faces differ at the worst [m]."""
    pose = Pose3.from_rpy(tuple(rng.uniform(-3, 3, 3)), tuple(rng.uniform(-3, 3, 3)))
    spec = mujoco.MjSpec()
    part = Part(Shape(Kind.MESH, (1.0, 1.0, 1.0), Mesh(Path("m.stl"), faces)), pose)
    add_part(spec, spec.worldbody, part, Group.WORLD_COLLISION)
    ball = spec.worldbody.add_body(name="ball", mocap=True)
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], name="ball")
    model = spec.compile()
    data = mujoco.MjData(model)
    felt = [g for g in range(model.ngeom) if model.geom_group[g] == Group.WORLD_CONTACT.value]
    worst = 0.0
    for point, distance in before(faces, rng):
        data.mocap_pos[0] = pose.apply(point[None])[0]
        mujoco.mj_kinematics(model, data)
        touched = min(
            mujoco.mj_geomDistance(model, data, geom, model.geom("ball").id, 1.0, None)
            for geom in felt
        )
        worst = max(worst, abs(touched - (distance - RADIUS)))
    return worst


def before(faces: Faces, rng: Chance, count: int = 12) -> list[tuple[Faces, float]]:
    """Return points beside faces, outside of what they enclose, and their distances from them."""
    solid = trimesh.Trimesh(*merged(faces), process=False)
    if solid.is_watertight:
        solid.fix_normals()
    found: list[tuple[Faces, float]] = []
    while len(found) < count:
        face = faces[rng.integers(len(faces))]
        normal = np.cross(face[1] - face[0], face[2] - face[0])
        normal *= rng.choice((-1.0, 1.0)) / np.linalg.norm(normal)
        point = rng.dirichlet((1, 1, 1)) @ face + rng.uniform(0.01, 0.04) * normal
        near = trimesh.triangles.closest_point(faces, np.repeat(point[None], len(faces), 0))
        if not (solid.is_watertight and encloses(solid, point)):
            found.append((point, float(np.linalg.norm(near - point, axis=1).min())))
    return found


def merged(faces: Faces) -> tuple[Faces, NDArray[np.int64]]:
    corners, index = np.unique(np.round(faces.reshape(-1, 3), 9), axis=0, return_inverse=True)
    return corners, index.reshape(-1, 3)


def encloses(solid: trimesh.Trimesh, point: Faces) -> bool:
    """Return whether a point is in a closed mesh, by its solid angle (van Oosterom 1983)."""
    a, b, c = np.moveaxis(solid.triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    top = np.einsum("ij,ij->i", a, np.cross(b, c))
    dot = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
    bottom = la * lb * lc + dot[0] * lc + dot[1] * la + dot[2] * lb
    return abs(float(np.sum(np.arctan2(top, bottom)))) > np.pi


def _ring(
    corners: int, radius: float, middle: tuple[float, float], gap: float = 0.0
) -> NDArray[np.float64]:
    """Return a polygon of walls, whose last one ends a gap [m] before the first begins."""
    angles = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    points = radius * np.column_stack((np.cos(angles), np.sin(angles))) + middle
    last = points[-1] - points[-2]
    points[-1] -= gap * last / np.hypot(*last)
    return np.hstack((points[:-1], points[1:]))


@pytest.mark.parametrize("seed", range(10))
def test_closed_walls_separate_inside_from_outside(seed: int) -> None:
    """Of any size, form and position, with pillars within; narrow gaps are closed."""
    rng = np.random.default_rng(seed)
    size, middle = float(rng.uniform(1.5, 40.0)), tuple(rng.uniform(-50.0, 50.0, 2).tolist())
    walls = [_ring(int(rng.integers(3, 9)), size, middle, gap=0.15 * (seed % 2))]
    turns = rng.uniform(0.0, 2.0 * math.pi, (4, 2))
    for angle, _ in turns:
        at = (middle[0] + 0.2 * size * math.cos(angle), middle[1] + 0.2 * size * math.sin(angle))
        walls.append(_ring(8, 0.1, at))
    enclosure = enclosure_of(np.vstack(walls), 0.1)
    if enclosure is None:
        assert len(walls[0]) == 3  # a triangle is less than half of what is around it
        return
    for angle, _ in turns:
        far = (middle[0] + 1.1 * size * math.cos(angle), middle[1] + 1.1 * size * math.sin(angle))
        assert enclosure.is_outside(*far)
        x, y = enclosure.nearest_inside(*far)[0].tolist()
        assert not enclosure.is_outside(x, y)
        assert math.hypot(x - middle[0], y - middle[1]) < size
    assert not enclosure.is_outside(*middle)


@pytest.mark.parametrize(
    "walls",
    [
        np.zeros((0, 4)),
        _ring(4, 3.0, (0.0, 0.0), gap=1.5),  # a door
        np.vstack([_ring(4, 0.5, (x, y)) for x in (-9.0, 9.0) for y in (-9.0, 9.0)]),  # boxes
        np.vstack([_ring(4, 4.0, (0.0, 0.0)), _ring(4, 0.3, (30.0, 0.0))]),  # a house in a street
    ],
)
def test_what_is_open_encloses_nothing(walls: NDArray[np.float64]) -> None:
    assert enclosure_of(walls, 0.2) is None
