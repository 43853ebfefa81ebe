"""Rates, delays and bandwidths over a window of messages; no ROS, no clock."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Spread:
    """Statistics of a window of values."""

    mean: float
    least: float
    most: float
    deviation: float
    count: int

    def __str__(self) -> str:
        return (
            f"\tmin: {self.least:.3f}s max: {self.most:.3f}s"
            f" std dev: {self.deviation:.5f}s window: {self.count}"
        )


def spread(values: deque[float]) -> Spread:
    """Return the spread of values, one at least [their unit]."""
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / len(values))
    return Spread(mean, min(values), max(values), deviation, len(values))


@dataclass
class Intervals:
    """The times between messages, the newest `window` of them.

    A time that is set back starts again.
    """

    window: int
    _last: float | None = None
    _values: deque[float] = field(default_factory=deque)

    def add(self, now: float) -> None:
        """Note a message at a time [s]."""
        if self._last is not None and now < self._last:
            self._values.clear()
        elif self._last is not None:
            self._values.append(now - self._last)
        self._last = now
        if len(self._values) > self.window:
            self._values.popleft()

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
    if rate < 1000:
        scale, digits, unit = 1.0, 0, "B"
    elif rate < 1_000_000:
        scale, digits, unit = 1e3, 2, "KB"
    else:
        scale, digits, unit = 1e6, 2, "MB"

    def text(size: float) -> str:
        return f"{size / scale:.{digits}f} {unit}"

    mean, least, most = sum(sizes) / len(sizes), min(sizes), max(sizes)
    return (
        f"{text(rate)}/s from {len(sizes)} messages\n"
        f"\tMessage size mean: {text(mean)} min: {text(least)} max: {text(most)}"
    )
