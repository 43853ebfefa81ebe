"""Sensor models: how likely a scan is at each particle, on the likelihood field."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.field import DistanceField, count_near, sum_at_endpoints


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

    def weigh(
        self, particles: NDArray[np.float64], endpoints: NDArray[np.float64], range_max: float
    ) -> Likelihood:
        """Return the likelihood of beams at particles.

        Args:
            particles: `(N, 3) float64` in the map frame [m, m, rad].
            endpoints: Where beams end in the base frame, `(B, 2) float64` [m], at least one.
            range_max: The lidar's longest range [m].
        """


def select_endpoints(scan: Scan, config: AmclConfig) -> NDArray[np.float64]:
    """Return the end points `(B, 2)` [m] in the base frame of at most `max_beams` usable beams.

    Beams are taken at even steps over the sweep, as nav2_amcl does; those without a return or out
    of the configured ranges are then left out.
    """
    low, high = range_limits(scan, config)
    step = max(1, (len(scan.ranges) - 1) // (config.max_beams - 1))
    ranges, angles = scan.ranges[::step], scan.angles[::step]
    with np.errstate(invalid="ignore"):
        usable = (ranges >= low) & (ranges < high)
    return _endpoints(scan, ranges[usable], angles[usable])


def all_endpoints(scan: Scan, config: AmclConfig) -> NDArray[np.float64]:
    """Return the end points `(M, 2)` [m] in the base frame of all usable beams."""
    low, high = range_limits(scan, config)
    with np.errstate(invalid="ignore"):
        usable = (scan.ranges >= low) & (scan.ranges < high)
    return _endpoints(scan, scan.ranges[usable], scan.angles[usable])


def range_limits(scan: Scan, config: AmclConfig) -> tuple[float, float]:
    """Return the shortest and longest range [m] that the configuration lets be used."""
    low = scan.range_min if config.laser_min_range < 0.0 else config.laser_min_range
    high = scan.range_max if config.laser_max_range < 0.0 else config.laser_max_range
    return max(low, scan.range_min), min(high, scan.range_max)


def _endpoints(
    scan: Scan, ranges: NDArray[np.float64], angles: NDArray[np.float64]
) -> NDArray[np.float64]:
    local = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
    return scan.T_base_sensor.apply(local)


class _Table:
    """A function of the distance field, tabulated once for each `range_max` seen."""

    def __init__(self, field: DistanceField, config: AmclConfig) -> None:
        self.field = field
        self._config = config
        self._range_max = -1.0
        self.density: NDArray[np.float32] = field.distances
        self.outside = 0.0

    def build(self, range_max: float) -> bool:
        """Tabulate the density of a hit; return whether the table changed."""
        if range_max == self._range_max:
            return False
        self._range_max = range_max
        self.density = self._density(self.field.distances, range_max).astype(np.float32)
        far = np.array([self.field.max_distance])
        self.outside = float(self._density(far, range_max)[0])
        return True

    def _density(self, distances: NDArray[np.floating], range_max: float) -> NDArray[np.float64]:
        c = self._config
        hit = c.z_hit * np.exp(-(distances.astype(np.float64) ** 2) / (2.0 * c.sigma_hit**2))
        return np.asarray(hit + c.z_rand / range_max)


class LikelihoodField:
    """nav2_amcl's `likelihood_field`: 1 plus the sum of the cubed densities of the beams.

    Source: nav2_amcl; after Probabilistic Robotics, table 6.3, whose product over beams it
    replaces because neighbouring beams are not independent.
    """

    def __init__(self, field: DistanceField, config: AmclConfig) -> None:
        self._table = _Table(field, config)
        self._cubed: NDArray[np.float32] = field.distances

    def weigh(
        self, particles: NDArray[np.float64], endpoints: NDArray[np.float64], range_max: float
    ) -> Likelihood:
        """See `SensorModel.weigh`."""
        table = self._table
        if table.build(range_max):
            self._cubed = table.density**3
        poses, cells = _in_cells(table.field, particles, endpoints)
        factors = 1.0 + sum_at_endpoints(self._cubed, table.outside**3, poses, cells)
        return Likelihood(factors, factors)


class LikelihoodFieldProb:
    """nav2_amcl's `likelihood_field_prob`: the product over beams, with beam skipping.

    Source: Thrun, Burgard, Fox, Probabilistic Robotics, 2005, table 6.3; skipping: nav2_amcl.
    """

    def __init__(self, field: DistanceField, config: AmclConfig) -> None:
        self._table = _Table(field, config)
        self._config = config
        self._logs: NDArray[np.float32] = field.distances

    def weigh(
        self, particles: NDArray[np.float64], endpoints: NDArray[np.float64], range_max: float
    ) -> Likelihood:
        """See `SensorModel.weigh`."""
        table = self._table
        if table.build(range_max):
            self._logs = np.log(table.density)
        poses, cells = _in_cells(table.field, particles, endpoints)
        if self._config.do_beamskip:
            cells = self._skip(poses, cells)
        sums = sum_at_endpoints(self._logs, math.log(table.outside), poses, cells)
        return Likelihood(np.exp(sums - sums.max()), np.exp(sums / len(cells)))

    def _skip(self, poses: NDArray[np.float64], cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave out beams that fit too few particles, unless that would be nearly all."""
        c = self._config
        fits = count_near(self._table.field.distances, c.beam_skip_distance, poses, cells)
        keep = fits > c.beam_skip_threshold * len(poses)
        skipped = 1.0 - keep.mean()
        return cells if skipped >= c.beam_skip_error_threshold else cells[keep]


def _in_cells(
    field: DistanceField, particles: NDArray[np.float64], endpoints: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return field.to_grid(particles), endpoints / field.frame.resolution


def make_sensor(field: DistanceField, config: AmclConfig) -> SensorModel:
    """Return the sensor model that the configuration names."""
    if config.laser_model_type == "likelihood_field":
        return LikelihoodField(field, config)
    return LikelihoodFieldProb(field, config)
