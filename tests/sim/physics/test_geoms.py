"""Shapes as MuJoCo has them: as large, as high and as solid as their parts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import Group, Kind, Mesh, Part, Shape, Terrain
from arjuna_sim.physics.geoms import add_part, rank_friction

AT = Pose3((1.0, 2.0, 3.0))
CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], np.float64)
FACES = [  # outward
    *((0, 3, 1), (0, 2, 3), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4)),
    *((2, 7, 3), (2, 6, 7), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)),
]
L = np.concatenate((CUBE[FACES], CUBE[FACES] + (1.0, 0, 0), CUBE[FACES] + (0, 0, 1.0)))


def added(*parts: Part, group: Group = Group.WORLD_COLLISION, most: int = 100) -> Any:
    """Return the model of a body of parts."""
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="b")
    for part in parts:
        add_part(spec, body, part, group, most)
    return spec.compile()


def mesh(triangles: np.ndarray, scale: tuple[float, ...] = (1.0, 1.0, 1.0)) -> Part:
    return Part(Shape(Kind.MESH, scale, Mesh(Path("m.stl"), triangles)), AT)


def down(model: Any, x: float, y: float, seen: Group = Group.WORLD_COLLISION) -> float:
    """Return how high a group reaches at a point, by a ray from above; -inf for nothing."""
    data, geom = mujoco.MjData(model), np.zeros((1, 1), np.int32)
    mujoco.mj_kinematics(model, data)
    groups = np.array([group == seen.value for group in range(6)], np.uint8)
    far = mujoco.mj_ray(
        model, data, np.array([x, y, 50.0]), np.array([0.0, 0.0, -1.0]), groups, 1, -1, geom, None
    )
    return 50.0 - far if far >= 0.0 else -np.inf


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        (Shape(Kind.BOX, (1.0, 2.0, 3.0)), (0.5, 1.0, 1.5)),
        (Shape(Kind.SPHERE, (0.7,)), (0.7, 0.0, 0.0)),
        (Shape(Kind.CYLINDER, (0.3, 2.0)), (0.3, 1.0, 0.0)),
        (Shape(Kind.CAPSULE, (0.3, 2.0)), (0.3, 1.0, 0.0)),
        (Shape(Kind.ELLIPSOID, (0.1, 0.2, 0.3)), (0.1, 0.2, 0.3)),
        (Shape(Kind.PLANE), (0.0, 0.0, 1.0)),
    ],
    ids=lambda value: value.kind.value if isinstance(value, Shape) else "",
)
def test_a_simple_shape_is_a_geom_of_half_its_edges(shape: Shape, size: tuple[float, ...]) -> None:
    model = added(Part(shape, AT, (0.1, 0.2, 0.3, 0.4), friction=0.25))
    assert model.ngeom == 1
    assert model.geom_type[0] == getattr(mujoco.mjtGeom, f"mjGEOM_{shape.kind.name}")
    assert model.geom_size[0] == pytest.approx(size)
    assert model.geom_pos[0] == pytest.approx(AT.position)
    assert model.geom_rgba[0] == pytest.approx((0.1, 0.2, 0.3, 0.4))
    assert (model.geom_friction[0, 0], model.geom_priority[0]) == (0.25, 1)
    assert model.body_mass.sum() == 0.0


def test_the_lower_friction_holds_with_the_stiffness_of_the_tyre() -> None:
    plane = "<geom type='plane' size='1 1 1' priority='{}' friction='{}'/>"
    ball = "<geom size='1' priority='1' friction='1' solref='0.1 2' solimp='0.5 0.6 0.01 0.4 3'/>"
    inside = plane.format(1, 0.2) + plane.format(1, 2.0) + plane.format(0, 0.1)
    text = f"<mujoco><worldbody>{inside}<body><freejoint/>{ball}</body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    rank_friction(model, [3])
    assert model.geom_priority.tolist() == [3, 1, 0, 2]
    for values in (model.geom_solref, model.geom_solimp):
        assert (values == values[3]).all(axis=1).tolist() == [True, False, False, True]


@pytest.mark.parametrize(
    ("group", "touches", "is_touched"),
    [
        (Group.WORLD_COLLISION, 1, 0),
        (Group.WORLD_CONTACT, 1, 0),
        (Group.ROBOT_COLLISION, 0, 1),
        (Group.WORLD_VISUAL, 0, 0),
        (Group.ROBOT_VISUAL, 0, 0),
    ],
)
def test_robots_touch_the_world_not_themselves(group: Group, touches: int, is_touched: int) -> None:
    model = added(Part(Shape(Kind.SPHERE, (1.0,))), group=group)
    assert (model.geom_contype[0], model.geom_conaffinity[0]) == (touches, is_touched)
    assert model.geom_group[0] == group.value
    assert model.geom_priority[0] == 0  # of a friction that no file names


@pytest.mark.parametrize("low", [0.0, 0.25])
def test_a_terrain_is_as_high_as_its_picture_says(low: float) -> None:
    heights = np.array([[low, 0.5, 1.0], [low, 0.5, 1.0]])
    ground = Shape(Kind.TERRAIN, (4.0, 2.0, 3.0), terrain=Terrain(Path("t.png"), heights))
    model = added(Part(ground, AT), Part(ground, Pose3((10.0, 0.0, 0.0))))
    assert (model.nhfield, model.ngeom) == (1, 2)  # one picture for both
    for x, height in (
        (-1.999, low),
        (-1.0, (low + 0.5) / 2),
        (0.0, 0.5),
        (1.0, 0.75),
        (1.999, 1.0),
    ):
        assert down(model, 1.0 + x, 2.0) == pytest.approx(3.0 + 3.0 * height, abs=5e-3)
        assert down(model, 10.0 + x, 0.9) == pytest.approx(3.0 * height, abs=5e-3)
    assert down(model, 1.0, 3.1) == -np.inf
    base = model.hfield_size[0]
    assert base == pytest.approx((2.0, 1.0, 3.0 * (1.0 - low), 1.0))


def test_a_level_terrain_is_thin_and_where_it_is() -> None:
    level = Terrain(Path("t.png"), np.full((3, 4), 0.5))
    model = added(Part(Shape(Kind.TERRAIN, (4.0, 2.0, 3.0), terrain=level), AT))
    assert model.hfield_size[0] == pytest.approx((2.0, 1.0, 1e-3, 1.0))
    assert (model.hfield_nrow[0], model.hfield_ncol[0]) == (3, 4)
    assert down(model, 1.5, 2.2) == pytest.approx(4.5, abs=1e-6)


def test_a_worlds_mesh_is_seen_as_it_is_and_touched_as_pieces() -> None:
    part = mesh(L, (1.0, 1.0, 2.0))  # two cubes side by side, one of them with one on it
    model = added(part, part)
    groups = model.geom_group.tolist()
    assert groups.count(0) == 2
    assert groups.count(4) >= 4
    assert (model.geom_contype[model.geom_group == 0] == 0).all()
    assert (model.geom_contype[model.geom_group == 4] == 1).all()
    assert model.nmesh == 1 + groups.count(4) // 2  # each is registered once
    for group in (Group.WORLD_COLLISION, Group.WORLD_CONTACT):
        assert down(model, 1.5, 2.5, group) == pytest.approx(7.0, abs=1e-6)
        assert down(model, 2.5, 2.5, group) == pytest.approx(5.0, abs=1e-6)
        assert down(model, 3.5, 2.5, group) == -np.inf
    whole = added(part, most=1).geom_group.tolist()
    assert whole == [0, 4]


def test_a_robots_mesh_is_touched_as_its_hull_and_a_drawn_one_is_as_it_is() -> None:
    own = added(mesh(L), group=Group.ROBOT_COLLISION)
    assert own.geom_group.tolist() == [3]
    assert down(own, 2.5, 2.5, Group.ROBOT_COLLISION) == pytest.approx(4.5, abs=1e-6)
    drawn = added(mesh(L), group=Group.WORLD_VISUAL)
    assert drawn.geom_group.tolist() == [1]
    assert down(drawn, 2.5, 2.5, Group.WORLD_VISUAL) == pytest.approx(4.0, abs=1e-6)


def test_a_mesh_of_one_face_can_be_drawn() -> None:
    model = added(mesh(CUBE[[[0, 1, 2]]]), group=Group.WORLD_VISUAL)
    assert down(model, 1.2, 2.2, Group.WORLD_VISUAL) == pytest.approx(3.0, abs=1e-6)
    assert down(model, 1.9, 2.9, Group.WORLD_VISUAL) == -np.inf
