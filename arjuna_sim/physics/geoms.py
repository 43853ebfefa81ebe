"""Shapes and worlds as MuJoCo geoms, and their friction."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.convex_pieces import PIECES_MAX
from arjuna_sim.model.geometry.shapes import Group, Kind, Mesh, Part
from arjuna_sim.model.world import World, is_ground
from arjuna_sim.physics.lights import add_look

_LEVEL, _BASE = 1e-3, 1.0  # least height of a terrain, and how deep it is below its lowest [m]


def name_friction(geom: Any, friction: float) -> None:
    """Give a spec's geom the friction that its file names, which `rank_friction` heeds."""
    geom.friction[0], geom.priority = friction, 1


def rank_friction(model: Any, wheels: Sequence[int]) -> None:
    """Let the lower friction hold wherever two named ones meet, and a named one over none.

    MuJoCo takes friction, stiffness and damping of the geom of the higher priority. So the ground
    that is more slippery than a tyre takes the tyre's stiffness and damping.

    Args:
        wheels: The geoms of the tyres.
    """
    named = np.flatnonzero(model.geom_priority > 0)
    friction = model.geom_friction[named, 0]
    levels = np.unique(friction)
    model.geom_priority[named] = len(levels) - np.searchsorted(levels, friction)
    if not wheels:
        return
    grounds = named[model.geom_bodyid[named] == 0]
    grounds = grounds[model.geom_priority[grounds] > model.geom_priority[list(wheels)].min()]
    model.geom_solref[grounds] = model.geom_solref[wheels[0]]
    model.geom_solimp[grounds] = model.geom_solimp[wheels[0]]


def add_part(spec: Any, body: Any, part: Part, group: Group, most: int = PIECES_MAX) -> list[Any]:
    """Add a part to a MuJoCo body, massless.

    A mesh of the world that is not convex is seen by rays as it is, and touched as many pieces; a
    mesh of the robot is touched as its convex hull.

    Args:
        group: Says whether it collides: visual groups do not.
        most: How many pieces a mesh may be touched as.

    Returns:
        The spec's geoms, in the order in which they were added.
    """
    if part.shape.kind is Kind.TERRAIN:
        return [_add_terrain(spec, body, part, group)]
    if part.picture is not None and group in (Group.WORLD_VISUAL, Group.ROBOT_VISUAL):
        return [_add_pictured(spec, body, part, group)]
    if part.shape.kind is not Kind.MESH:
        return [_add_simple(body, part, group)]
    assert part.shape.mesh is not None
    name = f"{part.shape.mesh.path}@{part.shape.size}"
    if group is Group.ROBOT_COLLISION:
        outer = part.shape.mesh.hull(part.shape.size)
        return [_add_mesh(spec, body, part, group, f"{name}#hull", outer)]
    points = (part.shape.mesh.triangles * np.array(part.shape.size)).reshape(-1, 3)
    drawn = _add_mesh(spec, body, part, group, name, points, faces=True)
    geoms = [drawn]
    if group is Group.WORLD_COLLISION:
        drawn.contype = 0
        found = part.shape.mesh.pieces(part.shape.size, most).corners
        names = [f"{name}#{most}#{i}" for i in range(len(found))]
        if spec.mesh(names[0]) is None:
            for called, piece in zip(names, found, strict=True):
                spec.add_mesh(name=called, uservert=piece.ravel())
        kind = mujoco.mjtGeom.mjGEOM_MESH
        look = _look(part, Group.WORLD_CONTACT)
        pieces = [body.add_geom(type=kind, meshname=called, **look) for called in names]
        if part.friction is not None:
            for geom in pieces:
                name_friction(geom, part.friction)
        geoms += pieces
    return geoms


def _add_pictured(spec: Any, body: Any, part: Part, group: Group) -> Any:
    """Add a box or mesh with a picture on it, as triangles with texture coordinates."""
    assert part.picture is not None
    picture = part.picture.path.as_posix()
    if spec.material(picture) is None:
        rows, columns, channels = part.picture.pixels.shape
        texture = spec.add_texture(name=picture, width=columns, height=rows, nchannel=channels)
        texture.type, texture.data = mujoco.mjtTexture.mjTEXTURE_2D, part.picture.pixels.tobytes()
        material = spec.add_material(name=picture)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = picture
    own = part.shape.mesh
    name = f"{picture}@{'' if own is None else own.path}@{part.shape.size}"
    if spec.mesh(name) is None:
        size = np.array(part.shape.size)
        points, coordinates = _sides(size) if own is None else _placed(own, size)
        spec.add_mesh(
            name=name,
            uservert=points.ravel(),
            usertexcoord=coordinates.ravel(),
            userface=np.arange(len(points)),
            userfacetexcoord=np.arange(len(points)),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
    geom = _new_mesh_geom(body, part, group, name)
    geom.material, geom.rgba = picture, [1.0, 1.0, 1.0, 1.0]
    return geom


def _placed(mesh: Mesh, size: Floats) -> tuple[Floats, Floats]:
    """Return what `_sides` does of a mesh at a scale."""
    assert mesh.skin is not None
    places = mesh.skin.places.reshape(-1, 2).astype(np.float64)
    return (mesh.triangles * size).reshape(-1, 3), places


def _sides(size: Floats) -> tuple[Floats, Floats]:
    """Return the corners of a box's triangles [m], and where they are in a picture, from its top.

    On the upright sides the picture's top is up; it is to +x on the top, to -x on the bottom.
    """
    points, coordinates = [], []
    for axis, up in ((0, 2), (1, 2), (2, 0)):
        for sign in (1.0, -1.0):
            normal, upward = np.zeros(3), np.zeros(3)
            normal[axis], upward[up] = sign, sign if axis == 2 else 1.0
            right = np.cross(upward, normal)
            for u, v in ((0, 1), (1, 1), (1, 0), (0, 1), (1, 0), (0, 0)):
                point = normal + (2 * u - 1) * right + (1 - 2 * v) * upward
                points.append(point * size / 2)
                coordinates.append((u, v))
    return np.array(points), np.array(coordinates, np.float64)


def _add_terrain(spec: Any, body: Any, part: Part, group: Group) -> Any:
    """Add a heightmap; MuJoCo's stretch from their lowest to their highest point."""
    terrain = part.shape.terrain
    assert terrain is not None
    x, y, z = part.shape.size
    low, high = float(terrain.heights.min()) * z, float(terrain.heights.max()) * z
    name = f"{terrain.path}@{part.shape.size}"
    if spec.hfield(name) is None:
        rows, columns = terrain.heights.shape
        stretched = (terrain.heights * z - low) / max(high - low, _LEVEL)
        spec.add_hfield(
            name=name,
            nrow=rows,
            ncol=columns,
            size=[x / 2, y / 2, max(high - low, _LEVEL), _BASE],
            userdata=stretched.ravel(),
        )
    placed = dataclasses.replace(part, pose=part.pose @ Pose3((0.0, 0.0, low)))
    geom = _new_geom(body, placed, group)
    geom.type, geom.hfieldname = mujoco.mjtGeom.mjGEOM_HFIELD, name
    return geom


def _look(part: Part, group: Group) -> dict[str, Any]:
    """Return what the geoms of a part have in common."""
    return {
        "pos": part.pose.position,
        "quat": part.pose.quaternion,
        "rgba": part.rgba,
        "group": group.value,
        "mass": 0.0,
        # Robot against world only: neither collides with itself.
        "contype": int(group in (Group.WORLD_COLLISION, Group.WORLD_CONTACT)),
        "conaffinity": int(group is Group.ROBOT_COLLISION),
    }


def _new_geom(body: Any, part: Part, group: Group) -> Any:
    geom = body.add_geom(**_look(part, group))
    if part.friction is not None:
        name_friction(geom, part.friction)
    return geom


def _add_simple(body: Any, part: Part, group: Group) -> Any:
    shape, geom = part.shape, _new_geom(body, part, group)
    geom.type = getattr(mujoco.mjtGeom, f"mjGEOM_{shape.kind.name}")
    if shape.kind is Kind.BOX:
        geom.size = [edge / 2 for edge in shape.size]
    elif shape.kind is Kind.ELLIPSOID:
        geom.size = shape.size
    elif shape.kind in (Kind.CYLINDER, Kind.CAPSULE):
        geom.size = [shape.size[0], shape.size[1] / 2, 0.0]
    elif shape.kind is Kind.SPHERE:
        geom.size = [shape.size[0], 0.0, 0.0]
    else:
        geom.size = [0.0, 0.0, 1.0]
    return geom


def _add_mesh(
    spec: Any, body: Any, part: Part, group: Group, name: str, points: Floats, faces: bool = False
) -> Any:
    if spec.mesh(name) is None:
        points = points if len(points) > 3 else np.vstack((points, points[::-1]))
        mesh = spec.add_mesh(name=name, uservert=points.ravel())
        if faces:
            mesh.userface = np.arange(len(points))
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    return _new_mesh_geom(body, part, group, name)


def _new_mesh_geom(body: Any, part: Part, group: Group, name: str) -> Any:
    geom = _new_geom(body, part, group)
    geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
    return geom


def add_world(spec: Any, world: World, own: Mapping[str, str] | None = None) -> list[str]:
    """Add a world's parts to MuJoCo's, and its look.

    Args:
        own: The bodies of models that have one of their own, by the models' names.

    Returns:
        For each geom added, in order, the model it belongs to; "" for the ground.
    """
    add_look(spec, world.look)
    names: list[str] = []
    bodies = {model: spec.worldbody.add_body(name=name) for model, name in (own or {}).items()}
    order = {model: i for i, model in enumerate(bodies)}  # MuJoCo has a body's geoms in one piece
    for body in sorted(world.bodies, key=lambda each: order.get(each.model, -1)):
        group = Group.WORLD_COLLISION if body.collides else Group.WORLD_VISUAL
        added = add_part(spec, bodies.get(body.model, spec.worldbody), body.part, group)
        for i, geom in enumerate(added, len(names)):
            geom.name = f"{body.model}::{i}"
        names.extend(["" if is_ground(body.model, body.part) else body.model] * len(added))
    return names
