"""The averages of laser_filters' LaserArrayFilter, beam by beam over scans."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from arjuna_core.config import param
from arjuna_sim.processing.sweep import Array, Mounted, Sweep

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

    name: str = param("average", "Its name.", read_only=True)
    type: str = param("", "Its class; empty for none.", choices=("", *_AVERAGED), read_only=True)
    params: Observations = field(default_factory=Observations)


@dataclass(frozen=True)
class AverageChain:
    """A chain of averages over scans."""

    filter1: AverageFilter = field(default_factory=AverageFilter)

    def averaged(self, values: Array, memory: deque[Array]) -> Array:
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
        result: Array = average(np.array(memory), axis=0)
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
