"""A scan with intensities, the form of what filters it, and filters by earlier scans."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.config import fixed, param
from arjuna_core.pose3 import Pose3

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

    ranges: Floats
    intensities: Floats
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    first: int = 0

    @property
    def angles(self) -> Floats:
        """Bearings of all beams [rad]."""
        count = len(self.ranges)
        return np.asarray(self.angle_min + self.angle_increment * np.arange(count), np.float64)

    def points(self, T: Pose3) -> Floats:
        """Return the end points in the frame in which the laser has a pose, `(N, 3)` [m]."""
        flat = np.cos(self.angles) * self.ranges, np.sin(self.angles) * self.ranges
        return T.apply(np.column_stack((*flat, np.zeros(len(self.ranges)))))

    def replaced(self, mask: Bools, value: float = math.nan) -> Sweep:
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


_AVERAGES: dict[str, Any] = {"Median": np.median, "Mean": np.mean}
_AVERAGED = tuple(
    f"filters/MultiChannel{name}Filter{kind}" for name in _AVERAGES for kind in ("Float", "Double")
)


@dataclass(frozen=True)
class Observations:
    """The number of scans of an average."""

    number_of_observations: int = param(5, "Scans.", minimum=1, maximum=1000)


@dataclass(frozen=True)
class AverageFilter:
    """One filter of a chain of averages over scans."""

    name: str = fixed("average", "Its name.")
    type: str = fixed("", "Its class; empty for none.", choices=("", *_AVERAGED))
    params: Observations = field(default_factory=Observations)


@dataclass(frozen=True)
class AverageChain:
    """A chain of averages over scans."""

    filter1: AverageFilter = field(default_factory=AverageFilter)

    def averaged(self, values: Floats, memory: deque[Floats]) -> Floats:
        """Return the average of values, beam by beam, and those before."""
        one = self.filter1
        if not one.type:
            return values
        if memory and len(memory[0]) != len(values):
            memory.clear()
        memory.append(values)
        while len(memory) > one.params.number_of_observations:
            memory.popleft()
        average = next(fn for name, fn in _AVERAGES.items() if name in one.type)
        result: Floats = average(np.array(memory), axis=0)
        return result


@dataclass(frozen=True)
class ArrayFilter:
    """Averages ranges and intensities over scans."""

    range_filter_chain: AverageChain = field(default_factory=AverageChain)
    intensity_filter_chain: AverageChain = field(default_factory=AverageChain)

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the average of the sweep and those before."""
        past = memory.setdefault("ranges", deque()), memory.setdefault("intensities", deque())
        ranges = self.range_filter_chain.averaged(sweep.ranges, past[0])
        return replace(
            sweep,
            ranges=ranges,
            intensities=self.intensity_filter_chain.averaged(sweep.intensities, past[1]),
        )
