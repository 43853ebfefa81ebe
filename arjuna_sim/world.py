"""The world: its MuJoCo geoms, and its true surfaces at a height."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_sim.sdf import GROUND, World
from arjuna_sim.shapes import Group, Kind, Part, add_geom

_ROUND = 64  # corners that stand for a circle
_SKY, _HORIZON = [0.4, 0.6, 0.9], [0.9, 0.9, 0.9]
_EMPTY = np.zeros((0, 4))


def add_world(spec: Any, world: World) -> list[str]:
    """Add a world's parts to MuJoCo's, lit by the sun.

    Args:
        spec: The `mujoco.MjSpec`.
        world: What to add.

    Returns:
        For each geom added, in order, the model it belongs to.
    """
    spec.worldbody.add_light(
        pos=[0.0, 0.0, 10.0],
        dir=[-0.5, 0.1, -0.9],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        castshadow=False,
    )
    spec.add_texture(
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=_SKY,
        rgb2=_HORIZON,
        width=64,
        height=384,
    )
    models = []
    for body in world.bodies:
        group = Group.WORLD_COLLISION if body.collides else Group.WORLD_VISUAL
        add_geom(spec, spec.worldbody, body.part, group)
        models.append(body.model)
    return models


def is_ground(model: str, part: Part) -> bool:
    """Tell whether a robot stands on a part rather than runs into it."""
    return model == GROUND or part.shape.kind is Kind.PLANE


def surfaces(world: World, height: float) -> NDArray[np.float64]:
    """Return where the world's solid parts are cut by a level plane.

    Args:
        world: The world.
        height: Of the plane above the ground [m].

    Returns:
        Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m] in the world's frame. Meshes
        count as their convex hulls, as MuJoCo's contacts take them.
    """
    cuts = [
        _cut(body.part, height)
        for body in world.bodies
        if body.collides and body.part.shape.kind is not Kind.PLANE
    ]
    return np.vstack([_EMPTY, *cuts])


def _cut(part: Part, height: float) -> NDArray[np.float64]:
    """Cut one convex part: all lines between corners on either side, then their hull."""
    shape, z = part.shape, part.pose.position[2]
    if shape.kind is Kind.SPHERE:
        radius = math.sqrt(max(0.0, shape.size[0] ** 2 - (height - z) ** 2))
        return _outline(_circle(radius) + part.pose.position[:2]) if radius > 0.0 else _EMPTY
    corners = part.pose.apply(_corners(part))
    above = corners[:, 2] > height
    if above.all() or not above.any():
        return _EMPTY
    high, low = corners[above][:, None], corners[~above][None]
    ratio = (height - low[..., 2]) / (high[..., 2] - low[..., 2])
    points = (low + ratio[..., None] * (high - low))[..., :2].reshape(-1, 2)
    return _outline(points[ConvexHull(points).vertices])


def _corners(part: Part) -> NDArray[np.float64]:
    """Return the corners of a convex shape in its own frame, `(N, 3)` [m]."""
    shape = part.shape
    if shape.kind is Kind.BOX:
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners: NDArray[np.float64] = signs * np.array(shape.size) / 2
        return corners
    if shape.kind is Kind.CYLINDER:
        ring = _circle(shape.size[0])
        ends = [np.full((_ROUND, 1), sign * shape.size[1] / 2) for sign in (-1, 1)]
        return np.vstack([np.hstack([ring, end]) for end in ends])
    assert shape.mesh is not None
    return np.asarray(_mesh_corners(shape.mesh) * np.array(shape.size), np.float64)


def _mesh_corners(path: Path) -> NDArray[np.float64]:
    spec = mujoco.MjSpec()
    spec.add_mesh(name="mesh", file=str(path))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    model = spec.compile()
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[0])
    corners = model.mesh_vert.astype(np.float64) @ turn.reshape(3, 3).T + model.mesh_pos[0]
    return np.asarray(corners[ConvexHull(corners).vertices], np.float64)


def _circle(radius: float) -> NDArray[np.float64]:
    angles = np.arange(_ROUND) * 2.0 * math.pi / _ROUND
    ring: NDArray[np.float64] = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return ring


def _outline(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Join corners to a closed line, `(N, 2)` to `(N, 4)`."""
    return np.hstack([corners, np.roll(corners, -1, axis=0)])
