"""Sensor models on the likelihood field: how likely a scan is at each particle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.sensors.scan_view import ScanView
from arjuna_slam.matching.lookup import bordered, sum_at_endpoints
from arjuna_slam.matching.map_field import MapField


@dataclass(frozen=True)
class Likelihood:
    """How well a scan fits each particle.

    Attributes:
        factors: What the particles' weights are multiplied by, `(N,) float64`, all positive.
        levels: The same on a scale that can be averaged from scan to scan, `(N,) float64`.
    """

    factors: NDArray[np.float64]
    levels: NDArray[np.float64]


class SensorModel(Protocol):
    """Weighs particles by a scan."""

    def weigh(self, particles: NDArray[np.float64], view: ScanView) -> Likelihood:
        """Return the likelihood of a scan's few beams at particles.

        Args:
            particles: `(N, 3) float64` in the map frame [m, m, rad].
            view: The scan, with at least one beam.
        """


class _Tabulated:
    """A table of what a beam's end is worth in each cell, made once for each `range_max` seen.

    Where the map is unknown nothing can be expected: there the density is at least that of a
    uniform reading.
    """

    def __init__(self, field: MapField, config: AmclConfig) -> None:
        self._field = field
        self._config = config
        self._range_max = -1.0
        self._table: NDArray[np.float32] = np.empty((0, 0), np.float32)

    def _sums(
        self, poses: NDArray[np.float64], cells: NDArray[np.float64], range_max: float
    ) -> NDArray[np.float64]:
        """Return what the beams that end in cells are worth together at each pose."""
        if range_max != self._range_max:
            self._range_max = range_max
            density = self._density(self._field.distances, range_max)
            unknown = self._field.unknown
            density[unknown] = np.maximum(density[unknown], 1.0 / range_max)
            outside = self._density(np.array([self._field.max_distance]), range_max)
            self._table = bordered(self._worth(density), float(self._worth(outside)[0]))
        return sum_at_endpoints(self._table, poses, cells).astype(np.float64)

    def _density(self, distances: NDArray[np.floating], range_max: float) -> NDArray[np.float64]:
        c = self._config
        hit = c.z_hit * np.exp(-(distances.astype(np.float64) ** 2) / (2.0 * c.sigma_hit**2))
        return np.asarray(hit + c.z_rand / range_max)

    @staticmethod
    def _worth(density: NDArray[np.float64]) -> NDArray[np.float64]:
        return density**3

    def _in_cells(
        self, particles: NDArray[np.float64], view: ScanView
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return particles and end points in grid coordinates."""
        return self._field.to_grid(particles), view.few.endpoints / self._field.frame.resolution


class LikelihoodField(_Tabulated):
    """nav2_amcl's `likelihood_field`: 1 plus the sum of the cubed densities of the beams.

    Source: nav2_amcl; after Probabilistic Robotics, table 6.3, whose product over beams it
    replaces because neighbouring beams are not independent.
    """

    def weigh(self, particles: NDArray[np.float64], view: ScanView) -> Likelihood:
        """See `SensorModel.weigh`."""
        factors = 1.0 + self._sums(*self._in_cells(particles, view), view.range_max)
        return Likelihood(factors, factors)


class LikelihoodFieldProb(_Tabulated):
    """nav2_amcl's `likelihood_field_prob`: the product over beams, with beam skipping.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 6.3; skipping: nav2_amcl.
    """

    def __init__(self, field: MapField, config: AmclConfig) -> None:
        super().__init__(field, config)
        within = config.beam_skip_distance
        self._near = bordered(field.distances < within, float(field.max_distance < within))

    def weigh(self, particles: NDArray[np.float64], view: ScanView) -> Likelihood:
        """See `SensorModel.weigh`."""
        poses, cells = self._in_cells(particles, view)
        if self._config.do_beamskip:
            cells = self._skip(poses, cells)
        sums = self._sums(poses, cells, view.range_max)
        return Likelihood(np.exp(sums - sums.max()), np.exp(sums / max(1, len(cells))))

    @staticmethod
    def _worth(density: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.log(density)

    def _skip(self, poses: NDArray[np.float64], cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave out beams that fit too few particles, unless that would be nearly all."""
        c = self._config
        near = [sum_at_endpoints(self._near, poses, cell[np.newaxis]) for cell in cells]
        keep = np.mean(near, axis=1, dtype=np.float64) > c.beam_skip_threshold
        skipped = 1.0 - keep.mean()
        return cells if skipped >= c.beam_skip_error_threshold else cells[keep]
