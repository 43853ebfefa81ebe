"""A world as MuJoCo geoms, lit by the sun."""

from __future__ import annotations

from typing import Any

import mujoco

from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.world import World, is_ground
from arjuna_sim.physics.geoms import add_part

_SKY, _HORIZON = [0.4, 0.6, 0.9], [0.9, 0.9, 0.9]


def add_world(spec: Any, world: World) -> list[str]:
    """Add a world's parts to MuJoCo's, lit by the sun.

    Args:
        spec: The `mujoco.MjSpec`.
        world: What to add.

    Returns:
        For each geom added, in order, the model it belongs to; "" for the ground.
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
    names = []
    for body in world.bodies:
        group = Group.WORLD_COLLISION if body.collides else Group.WORLD_VISUAL
        added = add_part(spec, spec.worldbody, body.part, group)
        names.extend(["" if is_ground(body.model, body.part) else body.model] * len(added))
    return names
