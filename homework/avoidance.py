"""Judges of `avoidance`."""

from typing import Any

import numpy as np

from bringup.homework.exercise import Mark
from bringup.homework.judges import touches

__all__ = ["distance", "moves", "touches"]


def distance(attempt: Any) -> Mark:
    """Judge how far it drives."""
    return Mark.of(-attempt.drive.length, -5.0, -1.0, "it drove {} m of 5")


def moves(attempt: Any) -> Mark:
    """Judge how long it stays within 0.2 m."""
    times, points = attempt.path[::10, 0], attempt.path[::10, 1:3]
    longest = 0.0
    for at, point in zip(times, points, strict=True):
        away = np.hypot(*(points[times > at] - point).T) > 0.2
        stayed = float(times[times > at][np.argmax(away)] if away.any() else times[-1]) - at
        longest = max(longest, stayed)
    return Mark.of(longest, 8.0, 20.0, "it was at one place for {} s")
