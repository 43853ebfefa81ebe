"""Sensor models on the likelihood field: how likely a scan is at each particle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Singles
from arjuna_core.raycast import cast
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.scan_view import ScanView
from arjuna_slam.matching.map_field import MapField, bordered, sum_at_endpoints

_HEADINGS = 360  # for which ranges are cast ahead: a degree each
_MILLIMETRE = 1e-3
_CONVERGED = 0.5  # nav2_amcl, pf_alloc: dist_threshold [m]
_FARTHEST = 32.0  # the cache has 15 bits for a range [m]
_UNSEEN, _UNKNOWN = 0, 1 << 15  # entries of the cache: not cast yet; the ray ends in the unknown


@dataclass(frozen=True)
class Likelihood:
    """Likelihood of a scan at each particle."""

    factors: Floats  # what the particles' weights are multiplied by, `(N,) float64`, all positive
    levels: Floats  # the same on a scale that can be averaged from scan to scan, `(N,) float64`


class SensorModel(Protocol):
    """Weighs particles by a scan."""

    def weigh(self, particles: Floats, view: ScanView) -> Likelihood:
        """Return the likelihood of a scan's few beams, at least one, at particles `(N, 3)`."""


class _Tabulated:
    """A table of the score of a beam that ends in each cell, made once for each `range_max` seen.

    Where the map is unknown nothing can be expected: there the density is at least that of a
    uniform reading.
    """

    def __init__(self, field: MapField, config: AmclConfig) -> None:
        self._field = field
        self._config = config
        self._range_max = -1.0
        self._table: Singles = np.empty((0, 0), np.float32)

    def _sums(self, poses: Floats, cells: Floats, range_max: float) -> Floats:
        if range_max != self._range_max:
            self._range_max = range_max
            density = self._density(self._field.distances, range_max)
            unknown = self._field.unknown
            density[unknown] = np.maximum(density[unknown], 1.0 / range_max)
            outside = self._density(np.array([self._field.max_distance]), range_max)
            self._table = bordered(self._score(density), float(self._score(outside)[0]))
        return sum_at_endpoints(self._table, poses, cells).astype(np.float64)

    def _density(self, distances: NDArray[np.floating], range_max: float) -> Floats:
        c = self._config
        hit = c.z_hit * np.exp(-(distances.astype(np.float64) ** 2) / (2.0 * c.sigma_hit**2))
        return np.asarray(hit + c.z_rand / range_max)

    @staticmethod
    def _score(density: Floats) -> Floats:
        return density**3

    def _in_cells(self, particles: Floats, view: ScanView) -> tuple[Floats, Floats]:
        return self._field.to_grid(particles), view.few.endpoints / self._field.frame.resolution


class LikelihoodField(_Tabulated):
    """nav2_amcl's `likelihood_field`: 1 plus the sum of the cubed densities of the beams.

    Source: nav2_amcl; after Probabilistic Robotics, table 6.3, whose product over beams it
    replaces because neighbouring beams are not independent.
    """

    def weigh(self, particles: Floats, view: ScanView) -> Likelihood:
        """See `SensorModel.weigh`."""
        factors = 1.0 + self._sums(*self._in_cells(particles, view), view.range_max)
        return Likelihood(factors, factors)


def _has_converged(particles: Floats) -> bool:
    """Return whether no particle is far from their mean; source: nav2_amcl, pf_update_converged."""
    off = np.abs(particles[:, :2] - particles[:, :2].mean(axis=0))
    return bool(off.max() <= _CONVERGED)


class LikelihoodFieldProb(_Tabulated):
    """nav2_amcl's `likelihood_field_prob`: the product over beams, with beam skipping.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 6.3; skipping: nav2_amcl.
    """

    def __init__(self, field: MapField, config: AmclConfig) -> None:
        super().__init__(field, config)
        within = config.beam_skip_distance
        self._near = bordered(field.distances < within, float(field.max_distance < within))

    def weigh(self, particles: Floats, view: ScanView) -> Likelihood:
        """See `SensorModel.weigh`."""
        poses, cells = self._in_cells(particles, view)
        if self._config.do_beamskip and _has_converged(particles):
            cells = self._skip(poses, cells)
        sums = self._sums(poses, cells, view.range_max)
        return Likelihood(np.exp(sums - sums.max()), np.exp(sums / max(1, len(cells))))

    @staticmethod
    def _score(density: Floats) -> Floats:
        least = np.finfo(np.float32).tiny  # without z_rand, far from obstacles the density runs out
        return np.asarray(np.log(np.maximum(density, least)))

    def _skip(self, poses: Floats, cells: Floats) -> Floats:
        """Leave out beams that fit too few particles, unless that would be nearly all."""
        c = self._config
        near = [sum_at_endpoints(self._near, poses, cell[np.newaxis]) for cell in cells]
        keep = np.mean(near, axis=1, dtype=np.float64) > c.beam_skip_threshold
        skipped = 1.0 - keep.mean()
        return cells if skipped >= c.beam_skip_error_threshold else cells[keep]


class BeamModel:
    """nav2_amcl's `beam`: 1 plus the sum of the beams' cubed densities, a mixture of four.

    A reading is the map's obstacle, something nearer, no return, or anything. Where the ray leaves
    the known map first, readings beyond that point are uniform.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 6.1; the sum: nav2_amcl.
    """

    def __init__(self, field: MapField, config: AmclConfig) -> None:
        self._field, self._config = field, config
        self._blocked = field.occupied | field.unknown
        headings = _HEADINGS
        bytes_max = 256e6  # of the cache; a large map gets coarser headings
        while headings > 45 and self._blocked.size * headings * 2 > bytes_max:
            headings //= 2
        # the system lends zeroed pages only as they are touched
        self._cache = np.zeros((*self._blocked.shape, headings), np.uint16)

    def weigh(self, particles: Floats, view: ScanView) -> Likelihood:
        """See `SensorModel.weigh`."""
        c, field = self._config, self._field
        beams, sensor = view.few, view.T_base_sensor
        mount = np.array([sensor.x, sensor.y]) / field.frame.resolution
        mixture = np.array([c.z_hit, c.z_short, c.z_max, c.z_rand, c.sigma_hit, c.lambda_short])
        factors = _weigh(
            self._cache,
            field.occupied,
            self._blocked,
            field.frame.resolution,
            view.range_max,
            mixture,
            np.ascontiguousarray(field.to_grid(particles)),
            mount,
            np.arctan2(beams.directions[:, 1], beams.directions[:, 0]),
            np.minimum(beams.ranges, _FARTHEST),
            beams.returned,
        )
        return Likelihood(factors, factors)


@njit(cache=True)
def _weigh(
    cache: NDArray[np.uint16],
    occupied: Bools,
    blocked: Bools,
    resolution: float,
    range_max: float,
    mixture: Floats,
    poses: Floats,
    mount: Floats,
    bearings: Floats,
    ranges: Floats,
    returned: Bools,
) -> Floats:
    factors = np.ones(len(poses))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        column = math.floor(poses[i, 0] + c * mount[0] - s * mount[1])
        row = math.floor(poses[i, 1] + s * mount[0] + c * mount[1])
        for j in range(len(bearings)):
            expected, known = _expected(
                cache,
                occupied,
                blocked,
                resolution,
                range_max,
                row,
                column,
                poses[i, 2] + bearings[j],
            )
            p = _density(mixture, ranges[j], returned[j], expected, known, range_max)
            factors[i] += p * p * p
    return factors


@njit(cache=True)
def _density(
    mixture: Floats, reading: float, returned: bool, expected: float, known: bool, range_max: float
) -> float:
    z_hit, z_short, z_max, z_rand, sigma, decay = mixture
    if not known and reading >= expected:
        return 1.0 / range_max
    p: float = z_rand / range_max if returned else z_max
    if known:
        p += z_hit * math.exp(-((reading - expected) ** 2) / (2.0 * sigma * sigma))
    if reading < expected:
        p += z_short * decay * math.exp(-decay * reading)
    return p


@njit(cache=True)
def _expected(
    cache: NDArray[np.uint16],
    occupied: Bools,
    blocked: Bools,
    resolution: float,
    range_max: float,
    row: int,
    column: int,
    bearing: float,
) -> tuple[float, bool]:
    """Return the range [m] at which a ray is stopped, and whether by an obstacle or no return.

    Else the ray enters the unknown there.
    """
    height, width, headings = cache.shape
    if not (0 <= row < height and 0 <= column < width):
        return 0.0, False
    turn = math.floor(bearing / (2.0 * math.pi) * headings + 0.5) % headings
    entry = cache[row, column, turn]
    if entry == _UNSEEN:
        ray = np.array([2.0 * math.pi * turn / headings])
        x, y = (column + 0.5) * resolution, (row + 0.5) * resolution
        stopped = cast(blocked, resolution, x, y, ray, range_max)[0]
        hit = cast(occupied, resolution, x, y, ray, range_max)[0]
        length = min(max(stopped, _MILLIMETRE), range_max, _FARTHEST)
        entry = np.uint16(length / _MILLIMETRE) | np.uint16(0 if hit == stopped else _UNKNOWN)
        cache[row, column, turn] = entry
    return (entry & (_UNKNOWN - 1)) * _MILLIMETRE, entry < _UNKNOWN


def make_sensor(field: MapField, config: AmclConfig) -> SensorModel:
    """Return the sensor model that the configuration names."""
    if config.laser_model_type == "likelihood_field":
        return LikelihoodField(field, config)
    if config.laser_model_type == "beam":
        return BeamModel(field, config)
    return LikelihoodFieldProb(field, config)
