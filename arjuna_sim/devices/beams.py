"""Beams in any direction: lidars of several rows, sonars and infrared sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.settings import CloudSettings

_SEEN = np.array([group == Group.WORLD_COLLISION.value for group in range(6)], np.uint8)


@dataclass(frozen=True)
class Cloud:
    """Points that a lidar of several rows sees at one instant, in its own frame.

    Attributes:
        points: Where beams end, `(N, 3) float32` [m]; beams without return are left out.
        rows: Which row each is of, from the lowest, `(N,) uint16`.
    """

    points: NDArray[np.float32]
    rows: NDArray[np.uint16]


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
        others = model.body_rootid[model.geom_bodyid] != own
        self._others = np.flatnonzero(is_robot & others)

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
        if len(self._hits) != len(rays):
            self._hits = np.zeros((len(rays), 1), np.int32)
        groups = self._model.geom_group
        others = self._others
        if len(others):
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
        if len(others):
            groups[others] = Group.ROBOT_COLLISION.value
        ranges[ranges < 0.0] = np.inf
        return ranges


class Beams:
    """Casts the beams of a lidar of several rows, or those in a sonar's cone, all at once.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Beams and ranges.
        rng: Where the noise comes from.
    """

    def __init__(self, model: Any, settings: CloudSettings, rng: np.random.Generator) -> None:
        self._settings = settings
        self._rng = rng
        self._caster = Rays(model, settings.site)
        across = np.linspace(settings.angle_min, settings.angle_max, settings.samples)
        if settings.samples == 1:
            across = np.array([(settings.angle_min + settings.angle_max) / 2])
        tilts = np.linspace(settings.tilt_min, settings.tilt_max, settings.rows)
        if settings.rows == 1:
            tilts = np.array([(settings.tilt_min + settings.tilt_max) / 2])
        tilt, turn = (grid.ravel() for grid in np.meshgrid(tilts, across, indexing="ij"))
        level = np.cos(tilt)
        self._rays = np.column_stack((level * np.cos(turn), level * np.sin(turn), np.sin(tilt)))
        self._rows = np.repeat(np.arange(settings.rows, dtype=np.uint16), settings.samples)

    def rebind(self, model: Any) -> None:
        """Go on with another model, in which the robot is the same."""
        self._caster.rebind(model)

    def cloud(self, data: Any) -> Cloud:
        """Return where the beams end.

        Args:
            data: The `mujoco.MjData`, with positions up to date.
        """
        settings, ranges = self._settings, self._ranges(data)
        valid = (ranges >= settings.range_min) & (ranges <= settings.range_max)
        points = self._rays[valid] * ranges[valid, None]
        return Cloud(points.astype(np.float32), self._rows[valid])

    def nearest(self, data: Any) -> float:
        """Return the shortest range, by REP 117 -inf for too near and +inf for nothing [m]."""
        settings, ranges = self._settings, self._ranges(data)
        nearest = float(ranges.min())
        if nearest < settings.range_min:
            return -np.inf
        return nearest if nearest <= settings.range_max else np.inf

    def _ranges(self, data: Any) -> NDArray[np.float64]:
        """Return the distances with their noise, inf where nothing is hit [m]."""
        site = self._caster.site
        rays = self._rays @ data.site_xmat[site].reshape(3, 3).T
        ranges = self._caster.cast(data, data.site_xpos[site], rays, self._settings.range_max)
        if self._settings.noise > 0.0:
            ranges += self._settings.noise * self._rng.standard_normal(len(ranges))
        return ranges
