"""Rates, delays and bandwidths over a window of messages; no ROS, no clock."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True)
class Spread:
    """Statistics of a window of values."""

    mean: float
    least: float
    most: float
    deviation: float
    window: int

    def __str__(self) -> str:
        return (
            f"\tmin: {self.least:.3f}s max: {self.most:.3f}s"
            f" std dev: {self.deviation:.5f}s window: {self.window}"
        )


def spread(values: deque[float]) -> Spread:
    """Return the spread of values, one at least [their unit]."""
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / len(values))
    return Spread(mean, min(values), max(values), deviation, len(values))


class Intervals:
    """The times between messages, the newest `window` of them; time set back starts again."""

    def __init__(self, window: int) -> None:
        self._last = math.inf
        self._values: deque[float] = deque(maxlen=window)

    def add(self, now: float) -> None:
        """Note a message at a time [s]."""
        if now < self._last:
            self._values.clear()
        else:
            self._values.append(now - self._last)
        self._last = now

    def spread(self) -> Spread | None:
        """Return the spread of the times [s], None before the second message."""
        return spread(self._values) if self._values else None


def rate_text(intervals: Spread) -> str:
    """Return what `ros2 topic hz` prints."""
    rate = 1.0 / intervals.mean if intervals.mean > 0.0 else 0.0
    return f"average rate: {rate:.3f}\n{intervals}"


def bandwidth_text(sizes: deque[int], duration: float) -> str:
    """Return what `ros2 topic bw` prints of sizes [bytes] that came in a duration [s]."""
    rate = sum(sizes) / duration
    units = ((1.0, 0, "B"), (1e3, 2, "KB"), (1e6, 2, "MB"))
    scale, digits, unit = units[(rate >= 1e3) + (rate >= 1e6)]
    mean, *ends = (
        f"{size / scale:.{digits}f} {unit}"
        for size in (sum(sizes) / len(sizes), min(sizes), max(sizes), rate)
    )
    return (
        f"{ends[2]}/s from {len(sizes)} messages\n"
        f"\tMessage size mean: {mean} min: {ends[0]} max: {ends[1]}"
    )
