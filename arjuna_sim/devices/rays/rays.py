"""Rays of a sensor, through the world and other robots."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_sim.devices.rays.solids import SOLIDS, cast
from arjuna_sim.model.geometry.shapes import Group

_SEEN = np.array([group == Group.WORLD_COLLISION.value for group in range(6)], np.uint8)


class Rays:
    """Casts rays of a sensor, which sees the world and other robots but not its own.

    Args:
        model: The compiled `mujoco.MjModel`.
        site: Name of the sensor's site.
    """

    def __init__(self, model: Any, site: str) -> None:
        self._name = site
        self._hits = np.zeros((0, 1), np.int32)
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._model = model
        self.site = int(model.site(self._name).id)
        own = model.body_rootid[model.site_bodyid[self.site]]
        is_robot = model.geom_group == Group.ROBOT_COLLISION.value
        others = is_robot & (model.body_rootid[model.geom_bodyid] != own)
        self._others = np.flatnonzero(others)
        self._seen = np.flatnonzero((others | _is_world(model)) & _is_drawn(model))
        self._are_solids = bool(np.isin(model.geom_type[self._seen], SOLIDS).all())

    def cast(
        self, data: Any, origin: NDArray[np.float64], rays: NDArray[np.float64], reach: float
    ) -> NDArray[np.float64]:
        """Return exact distances from one place along unit vectors, inf where nothing is hit [m].

        Args:
            data: The `mujoco.MjData`, with positions up to date.
            origin: The place, `(3,) float64` [m].
            rays: The unit vectors, `(N, 3) float64`.
            reach: How far they go [m].
        """
        if not self._are_solids:
            return self._cast_at_meshes(data, origin, rays, reach)
        model, ranges = self._model, np.empty(len(rays))
        kinds, sizes, bounds = model.geom_type, model.geom_size, model.geom_rbound
        places, rotations = data.geom_xpos, data.geom_xmat
        cast(origin, rays, reach, self._seen, kinds, sizes, bounds, places, rotations, ranges)
        return ranges

    def _cast_at_meshes(
        self, data: Any, origin: NDArray[np.float64], rays: NDArray[np.float64], reach: float
    ) -> NDArray[np.float64]:
        """Let MuJoCo cast, which knows meshes and terrain."""
        if len(self._hits) != len(rays):
            self._hits = np.zeros((len(rays), 1), np.int32)
        groups, others = self._model.geom_group, self._others
        groups[others] = Group.WORLD_COLLISION.value  # which rays see
        ranges = np.empty(len(rays))
        mujoco.mj_multiRay(
            self._model,
            data,
            np.ascontiguousarray(origin).reshape(3, 1),
            np.ascontiguousarray(rays).reshape(-1, 1),
            _SEEN,
            True,
            -1,
            self._hits,
            ranges.reshape(-1, 1),
            None,
            len(rays),
            reach,
        )
        groups[others] = Group.ROBOT_COLLISION.value
        ranges[ranges < 0.0] = np.inf
        return ranges


def _is_world(model: Any) -> NDArray[np.bool_]:
    return np.asarray(model.geom_group == Group.WORLD_COLLISION.value)


def _is_drawn(model: Any) -> NDArray[np.bool_]:
    """Tell which geoms are not wholly transparent: those that are MuJoCo's rays pass through."""
    material, alpha = model.geom_matid, model.geom_rgba[:, 3].copy()
    has_material = material >= 0
    alpha[has_material] = model.mat_rgba[material[has_material], 3]
    return np.asarray(alpha != 0.0)
