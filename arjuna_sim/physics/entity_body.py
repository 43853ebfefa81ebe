"""Entities as MuJoCo bodies, each beside the world's static one."""

from __future__ import annotations

from typing import Any

import numpy as np

from arjuna_sim.model.entities import Entity
from arjuna_sim.model.shapes import Group
from arjuna_sim.physics.geoms import add_part

_THIN = 1e-3  # least extent that inertia is computed with [m]


def add_entity(spec: Any, entity: Entity) -> int:
    """Add an entity to a MuJoCo world.

    One that is held or follows a path is a mocap body: nothing moves it but `Stage`. One with a
    mass is a free body, with the inertia of its bounding box.

    Args:
        spec: The `mujoco.MjSpec`.
        entity: What to add.

    Returns:
        How many geoms it has.
    """
    held = entity.mass == 0.0
    body = spec.worldbody.add_body(
        name=entity.body, pos=entity.start.position, quat=entity.start.quaternion, mocap=held
    )
    geoms = [
        geom
        for parts, group in (
            (entity.solid, Group.WORLD_COLLISION),
            (entity.drawn or entity.solid, Group.WORLD_VISUAL),
        )
        for part in parts
        for geom in add_part(spec, body, part, group)
    ]
    if not held:
        body.add_freejoint(name=entity.body)
        _set_mass(body, entity)
        for geom in geoms:  # it meets the world and its like, as robots do
            geom.conaffinity = geom.contype
    return len(geoms)


def _set_mass(body: Any, entity: Entity) -> None:
    low, high = entity.bounds()
    x, y, z = np.maximum(high - low, _THIN) ** 2
    body.mass, body.ipos, body.explicitinertial = entity.mass, (low + high) / 2, True
    body.inertia = np.array([y + z, x + z, x + y]) * entity.mass / 12.0


def addresses_of(model: Any, entity: Entity) -> tuple[int, int, int]:
    """Return an entity's addresses: mocap index (-1 for a free body), in qpos, in qvel."""
    body = model.body(entity.body)
    mocap = int(model.body_mocapid[body.id])
    if mocap >= 0:
        return mocap, -1, -1
    joint = model.joint(entity.body)
    return -1, int(joint.qposadr[0]), int(joint.dofadr[0])
