"""Grip: of two surfaces that touch, the more slippery one says how much they rub, as in Gazebo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


def name_friction(geom: Any, friction: float) -> None:
    """Give a spec's geom the friction that its file names, which `rank_friction` heeds."""
    geom.friction[0], geom.priority = friction, 1


def rank_friction(model: Any, wheels: Sequence[int]) -> None:
    """Let the lower friction hold wherever two named ones meet, and a named one over none.

    MuJoCo takes friction, stiffness and damping of the geom of the higher priority. So the ground
    that is more slippery than a tyre takes the tyre's stiffness and damping.

    Args:
        model: The compiled `mujoco.MjModel`, which is changed.
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
