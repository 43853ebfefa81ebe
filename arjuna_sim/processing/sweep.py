"""A scan with intensities, and the form of what filters it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Mounted = Callable[[str], Pose3]
"""Returns the laser's pose in a frame."""


@dataclass(frozen=True)
class Sweep:
    """A scan with intensities.

    Attributes:
        ranges: `(N,) float64` [m].
        intensities: `(N,) float64`, or of length 0.
        angle_min: Bearing of beam 0 [rad].
        angle_increment: From one beam to the next [rad].
        first: The number of beam 0 in the scan that the laser sent.
    """

    ranges: Array
    intensities: Array
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    first: int = 0

    @property
    def angles(self) -> Array:
        """Bearings of all beams [rad]."""
        count = len(self.ranges)
        return np.asarray(self.angle_min + self.angle_increment * np.arange(count), np.float64)

    def points(self, T: Pose3) -> Array:
        """Return the end points in the frame in which the laser has a pose, `(N, 3)` [m]."""
        flat = np.cos(self.angles) * self.ranges, np.sin(self.angles) * self.ranges
        return T.apply(np.column_stack((*flat, np.zeros(len(self.ranges)))))

    def replaced(self, mask: Mask, value: float = math.nan) -> Sweep:
        """Return the sweep with a value in place of the ranges of a mask."""
        return replace(self, ranges=np.where(mask, value, self.ranges))

    def cut(self, start: int, end: int) -> Sweep:
        """Return the beams from one up to another."""
        return replace(
            self,
            ranges=self.ranges[start:end],
            intensities=self.intensities[start:end],
            angle_min=self.angle_min + start * self.angle_increment,
            first=self.first + start,
        )


class ScanFilter(Protocol):
    """A filter; one that remembers scans keeps them in `memory`, a dictionary of its own."""

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep filtered."""
