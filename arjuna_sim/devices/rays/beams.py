"""Beams in any direction: lidars of several rows, sonars and infrared sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_sim.devices.device import Mount, simulates
from arjuna_sim.devices.rays.rays import Rays
from arjuna_sim.devices.sensors.lidar import CloudSettings, RangeSettings


@dataclass(frozen=True)
class Cloud:
    """Points that a lidar of several rows sees at one instant, in its own frame.

    Attributes:
        points: Where beams end, `(N, 3) float32` [m]; beams without return are left out.
        rows: Which row each is of, from the lowest, `(N,) uint16`.
    """

    points: NDArray[np.float32]
    rows: NDArray[np.uint16]


class Beams:
    """Casts the beams of a lidar of several rows, or those in a sonar's cone, all at once."""

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
        """Continue with another model, in which the robot is the same."""
        self._caster.rebind(model)

    def settle(self) -> None:
        """Do nothing: no motion is remembered."""

    def _ranges(self, data: Any) -> NDArray[np.float64]:
        """Return the distances with their noise, inf where nothing is hit [m]."""
        site = self._caster.site
        rays = self._rays @ data.site_xmat[site].reshape(3, 3).T
        ranges = self._caster.cast(data, data.site_xpos[site], rays, self._settings.range_max)
        if self._settings.noise > 0.0:
            ranges += self._settings.noise * self._rng.standard_normal(len(ranges))
        return ranges


class CloudLidar(Beams):
    """A lidar of several rows."""

    def read(self, data: Any, now: float) -> Cloud:
        """Return the points where the beams end."""
        settings, ranges = self._settings, self._ranges(data)
        valid = (ranges >= settings.range_min) & (ranges <= settings.range_max)
        points = self._rays[valid] * ranges[valid, None]
        return Cloud(points.astype(np.float32), self._rows[valid])


class RangeSensor(Beams):
    """A sonar or an infrared sensor."""

    def read(self, data: Any, now: float) -> float:
        """Return the shortest range, by REP 117 -inf for too near and +inf for nothing [m]."""
        settings, ranges = self._settings, self._ranges(data)
        nearest = float(ranges.min())
        if nearest < settings.range_min:
            return -np.inf
        return nearest if nearest <= settings.range_max else np.inf


@simulates(CloudSettings)
def _cloud(settings: CloudSettings, mount: Mount) -> CloudLidar:
    return CloudLidar(mount.model, settings, mount.rng)


@simulates(RangeSettings)
def _range(settings: RangeSettings, mount: Mount) -> RangeSensor:
    return RangeSensor(mount.model, settings, mount.rng)
