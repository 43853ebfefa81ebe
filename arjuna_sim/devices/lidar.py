"""Lidars and sonars: rays through the world, with noise, dropouts and beams at their instants."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Singles
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_sim.devices.device import Mount, StaticDevice, simulates
from arjuna_sim.devices.rays import Rays
from arjuna_sim.devices.sensors.lidar import (
    CloudSettings,
    LidarConfig,
    LidarSettings,
    RangeSettings,
)


class Lidar:
    """Casts the beams of a sweep, all at once or each from where the sensor was at its instant.

    Args:
        T_base_sensor: Where the lidar sits, seen from above.
    """

    def __init__(
        self,
        model: Any,
        settings: LidarSettings,
        T_base_sensor: SE2,
        config: LidarConfig,
        rng: np.random.Generator,
    ) -> None:
        self._settings = settings
        self._T_base_sensor = T_base_sensor
        self._config = config
        self._noise = settings.noise if config.noise < 0.0 else config.noise
        self._rng = rng
        self._rays = Rays(model, settings.site, settings.rendered)
        span = settings.angle_max - settings.angle_min
        self._increment = span / max(1, settings.samples - 1)
        angles = settings.angle_min + self._increment * np.arange(settings.samples)
        self._beams = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))
        # A mirror that turns once a scan: a narrow view is swept in a part of the period.
        revolutions = self._increment / (2.0 * math.pi)
        self._time_increment = revolutions / settings.rate if config.sweep else 0.0
        self._ages = self._time_increment * np.arange(settings.samples - 1, -1, -1)
        self._trail: list[tuple[float, Floats]] = []

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._rays.rebind(model)

    def settle(self) -> None:
        """Forget the path, since the robot was lifted to another pose."""
        self._trail.clear()

    def follow(self, data: Any, now: float) -> None:
        """Remember the sensor's pose at a time [s]; to be called each tick, before `scan`."""
        if not self._config.sweep:
            return
        site = self._rays.site
        pose = np.concatenate((data.site_xpos[site], data.site_xmat[site]))
        self._trail.append((now, pose))
        oldest = now - float(self._ages[0])
        while len(self._trail) > 2 and self._trail[1][0] <= oldest:
            self._trail.pop(0)

    def read(self, data: Any, now: float) -> Scan:
        """Return a sweep that ends now, of a lidar that is read from time to time."""
        self.follow(data, now)
        return self.scan(data, now)

    def scan(self, data: Any, now: float) -> Scan:
        """Return a sweep that ends now; the robot itself is not seen.

        By REP 117 a beam without return reads +inf, one that returns from nearer than the minimum
        -inf.

        Args:
            data: The `mujoco.MjData`, with positions up to date.
        """
        settings = self._settings
        ranges = self._sweep(data, now) if self._config.sweep else self._cast_at_once(data)
        ranges += self._noise * self._rng.standard_normal(len(ranges))
        _limit(ranges, settings.range_min, settings.range_max)
        if self._config.dropout > 0.0:
            ranges[self._rng.random(len(ranges)) < self._config.dropout] = np.inf
        return Scan(
            ranges,
            settings.angle_min,
            self._increment,
            settings.range_min,
            settings.range_max,
            now - float(self._ages[0]),
            self._time_increment,
            T_base_sensor=self._T_base_sensor,
        )

    def _cast_at_once(self, data: Any) -> Floats:
        site = self._rays.site
        rotation = data.site_xmat[site].reshape(3, 3)
        return self._cast(data, data.site_xpos[site], self._beams @ rotation.T)

    def _sweep(self, data: Any, now: float) -> Floats:
        """Cast beams from where the sensor was, those from points close together at once."""
        times = np.array([time for time, _ in self._trail])
        poses = np.array([pose for _, pose in self._trail])
        columns = [np.interp(now - self._ages, times, poses[:, i]) for i in range(12)]
        origins = np.column_stack(columns[:3])
        rays = np.column_stack(
            [
                columns[3 + 3 * i] * self._beams[:, 0] + columns[4 + 3 * i] * self._beams[:, 1]
                for i in range(3)
            ]
        )
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        path = float(np.linalg.norm(np.diff(origins, axis=0), axis=1).sum())
        # Beams cast from one point may lie up to 1 mm apart on the sensor's path.
        count = min(len(rays), 1 + int(path / 1e-3))
        return np.concatenate(
            [
                self._cast(data, some[len(some) // 2], beams)
                for some, beams in zip(
                    np.array_split(origins, count), np.array_split(rays, count), strict=True
                )
            ]
        )

    def _cast(self, data: Any, origin: Floats, rays: Floats) -> Floats:
        """Return exact distances from one point along unit vectors, inf where nothing is hit."""
        # A surface 6 sigma beyond the range is read within it once in 1e9 beams.
        reach = self._settings.range_max + 6.0 * self._noise
        return self._rays.cast(data, origin, rays, self._settings.range_min, reach)


@simulates(LidarSettings)
def _lidar(settings: LidarSettings, mount: Mount) -> Lidar:
    T_base_sensor = mount.T_base_sensor.planar()
    return Lidar(mount.model, settings, T_base_sensor, mount.config.lidar, mount.rng)


@njit(cache=True)
def _limit(ranges: Floats, nearest: float, furthest: float) -> None:
    for i in range(len(ranges)):
        if ranges[i] < nearest:
            ranges[i] = -np.inf
        elif ranges[i] > furthest:
            ranges[i] = np.inf


@dataclass(frozen=True)
class Cloud:
    """Points that a lidar of several rows sees at one instant, in its own frame.

    Attributes:
        points: Where beams end, `(N, 3) float32` [m]; beams without return are left out.
        rows: Which row each is of, from the lowest, `(N,) uint16`.
    """

    points: Singles
    rows: NDArray[np.uint16]


class Beams(StaticDevice):
    """Casts the beams of a lidar of several rows, or those in a sonar's cone, all at once."""

    def __init__(self, settings: CloudSettings, mount: Mount) -> None:
        self._caster = Rays(mount.model, settings.site, settings.rendered)
        super().__init__(settings, mount)
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

    def _ranges(self, data: Any) -> Floats:
        """Return the distances with their noise, inf where nothing is hit [m]."""
        site = self._caster.site
        rays = self._rays @ data.site_xmat[site].reshape(3, 3).T
        ends = self._settings.range_min, self._settings.range_max
        ranges = self._caster.cast(data, data.site_xpos[site], rays, *ends)
        if self._settings.noise > 0.0:
            ranges += self._settings.noise * self._rng.standard_normal(len(ranges))
        return ranges


@simulates(CloudSettings)
class CloudLidar(Beams):
    """A lidar of several rows."""

    def read(self, data: Any, now: float) -> Cloud:
        """Return the points where the beams end."""
        settings, ranges = self._settings, self._ranges(data)
        valid = (ranges >= settings.range_min) & (ranges <= settings.range_max)
        points = self._rays[valid] * ranges[valid, None]
        return Cloud(points.astype(np.float32), self._rows[valid])


@simulates(RangeSettings)
class RangeSensor(Beams):
    """A sonar or an infrared sensor."""

    def read(self, data: Any, now: float) -> float:
        """Return the shortest range, by REP 117 -inf for too near and +inf for nothing [m]."""
        settings, ranges = self._settings, self._ranges(data)
        nearest = float(ranges.min())
        if nearest < settings.range_min:
            return -np.inf
        return nearest if nearest <= settings.range_max else np.inf
