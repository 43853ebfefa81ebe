"""Matching on a map: a pose moved to where the scan fits best, and how well it fits there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.sensors.agreement import share_agreeing
from arjuna_slam.amcl.sensors.scan_view import ScanView
from arjuna_slam.matching.map_field import MapField

# Coarse to fine, so that the basin is wide and the end unmoved by what the map does not have [m]
_SCALES = np.array((0.36, 0.36, 0.24, 0.12, 0.12, 0.12, 0.12))
_WITHIN = np.array((0.5, 0.5, math.radians(15.0)))  # what ends farther away is another place
_WORTH = 0.02  # agreement by which another start must be better; less is chance
_STARTS = [SE2(0.2 * math.cos(a), 0.2 * math.sin(a)) for a in np.arange(8) * math.pi / 4]
ANYWHERE = np.array((1.0, 1.0, 1.0))  # deviations of a pose of which little is known [m, m, rad]


class MapMatcher:
    """Matches scans with a map.

    Args:
        config: Parameters.
        field: The map.
    """

    def __init__(self, config: AmclConfig, field: MapField) -> None:
        self._config = config
        self.field = field

    def agreement(self, pose: SE2, view: ScanView) -> float:
        """Return the share of beams (0..1) that agree with the map at a pose of the base."""
        return share_agreeing(self.field, pose, view, self._config.agreement_distance)

    def refined(self, pose: SE2, view: ScanView, deviations: NDArray[np.float64] = ANYWHERE) -> SE2:
        """Return the pose at which beams end nearest to obstacles, near a given one.

        Where the map explains that badly, and many beams end near by, the others are tried alone.

        Args:
            pose: Of the base in the map. Where the scan says nothing, along a bare corridor, it
                stays, and it is returned where no place near it fits.
            view: The scan.
            deviations: How far the pose may be off, `(3,) float64` [m, m, rad].
        """
        everything, *others = view.readings
        best = self._moved(pose, everything, deviations)
        score = self.agreement(best, view) if others else 1.0
        if score >= self._config.relocalize_doubt:
            return best
        for ends in others:  # people pull the scan to the walls that they stand before
            other = self._moved(pose, ends, deviations)
            if self.agreement(other, view) > score + _WORTH:
                best = other
        return best

    def _moved(self, pose: SE2, ends: NDArray[np.float64], deviations: NDArray[np.float64]) -> SE2:
        """Return the pose near a given one at which ends of beams lie nearest to obstacles."""
        information = np.diag(1.0 / np.maximum(deviations, 1e-3) ** 2)
        found = self.field.refine(pose, ends, information, _SCALES, self._config.match_deviation)
        change = (found.x - pose.x, found.y - pose.y, wrap(found.theta - pose.theta))
        return found if (np.abs(change) <= _WITHIN).all() else pose

    def best_near(
        self, pose: SE2, view: ScanView, deviations: NDArray[np.float64]
    ) -> tuple[SE2, float]:
        """Return the refined pose and its agreement; where poor, the best of several starts.

        A wall has two faces, and matching may settle on the wrong one.

        Args:
            pose: Of the base in the map.
            view: The scan.
            deviations: How far the pose may be off, `(3,) float64` [m, m, rad].
        """
        best = self.refined(pose, view, deviations)
        score = self.agreement(best, view)
        if score >= self._config.relocalize_doubt:
            return best, score
        for start in _STARTS:
            other = self.refined(SE2(pose.x + start.x, pose.y + start.y, pose.theta), view)
            other_score = self.agreement(other, view)
            if other_score > score + _WORTH:
                best, score = other, other_score
        return best, score
