"""Rates, delays and bandwidths over a window of messages; no ROS, no clock."""

from __future__ import annotations

import math
from collections import deque

import numpy as np


def spread_text(values: deque[float]) -> str:
    """Return what `ros2 topic hz` and `delay` print of the spread of values, one at least [s]."""
    return (
        f"\tmin: {min(values):.3f}s max: {max(values):.3f}s"
        f" std dev: {np.std(values):.5f}s window: {len(values)}"
    )


class Intervals:
    """The times between messages, the newest `window` of them; time set back starts again.

    Attributes:
        values: These [s].
    """

    def __init__(self, window: int) -> None:
        self._last = math.inf
        self.values: deque[float] = deque(maxlen=window)

    def add(self, now: float) -> None:
        """Note a message at a time [s]."""
        if now < self._last:
            self.values.clear()
        else:
            self.values.append(now - self._last)
        self._last = now

    def text(self) -> str:
        """Return what `ros2 topic hz` prints, from the second message on."""
        mean = np.mean(self.values)
        rate = 1.0 / mean if mean > 0.0 else 0.0
        return f"average rate: {rate:.3f}\n{spread_text(self.values)}"


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
