"""The planar lidar: rays through the world, with noise."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_sim.gazebo import LidarSettings
from arjuna_sim.shapes import Group

_SIGMAS = 6.0  # a surface just beyond the range may be read within it
_HIT = np.array([group == Group.WORLD_COLLISION.value for group in range(6)], np.uint8)


class Lidar:
    """Casts all beams of a sweep at one instant.

    Args:
        model: The compiled `mujoco.MjModel`.
        settings: Beams and ranges.
        T_base_sensor: Where the lidar sits, seen from above.
        noise: Standard deviation of a range [m].
        rng: Where chance comes from.
    """

    def __init__(
        self,
        model: Any,
        settings: LidarSettings,
        T_base_sensor: SE2,
        noise: float,
        rng: np.random.Generator,
    ) -> None:
        self._model = model
        self._settings = settings
        self._T_base_sensor = T_base_sensor
        self._noise = noise
        self._rng = rng
        self._site = model.site(settings.link).id
        span = settings.angle_max - settings.angle_min
        self._increment = span / max(1, settings.samples - 1)
        angles = settings.angle_min + self._increment * np.arange(settings.samples)
        self._beams = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))
        self._hits = np.zeros(settings.samples, np.int32)

    def scan(self, data: Any, stamp: float) -> Scan:
        """Return a sweep of the world as it is now; the robot itself is not seen.

        Args:
            data: The `mujoco.MjData`, with positions up to date.
            stamp: Time of the sweep [s].
        """
        settings = self._settings
        ranges = self._cast(data)
        ranges += self._noise * self._rng.standard_normal(len(ranges))
        ranges[ranges < settings.range_min] = np.nan
        ranges[ranges > settings.range_max] = np.inf
        return Scan(
            ranges,
            settings.angle_min,
            self._increment,
            settings.range_min,
            settings.range_max,
            stamp,
            T_base_sensor=self._T_base_sensor,
        )

    def _cast(self, data: Any) -> NDArray[np.float64]:
        """Return exact distances, inf where nothing is hit."""
        turn = data.site_xmat[self._site].reshape(3, 3)
        rays = np.ascontiguousarray(self._beams @ turn.T).reshape(-1, 1)
        ranges = np.empty(len(self._beams))
        cutoff = self._settings.range_max + _SIGMAS * self._noise
        mujoco.mj_multiRay(
            self._model,
            data,
            data.site_xpos[self._site].reshape(3, 1),
            rays,
            _HIT,
            True,
            -1,
            self._hits.reshape(-1, 1),
            ranges.reshape(-1, 1),
            None,
            len(ranges),
            cutoff,
        )
        ranges[ranges < 0.0] = np.inf
        return ranges
