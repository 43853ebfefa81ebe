"""Judges of `pid`."""

from typing import Any

import numpy as np

from bringup.homework.exercise import Mark
from bringup.homework.judges import stops

__all__ = ["overshoot", "quick", "reaches", "stops"]


def reaches(attempt: Any) -> Mark:
    """Judge where it ends."""
    return Mark.of(_gaps(attempt)[-1], 0.05, 0.30, "it ended {} m from the goal")


def quick(attempt: Any) -> Mark:
    """Judge when it is there."""
    gap, at = attempt.nearest(*attempt.exercise.goals[0], within=0.10)
    if gap > 0.10:
        return Mark(0.0, f"it came no nearer than {gap:.2f} m")
    return Mark.of(at, 15.0, 25.0, "it was at the goal after {} s")


def overshoot(attempt: Any) -> Mark:
    """Judge how far it goes once it was there."""
    gap, at = attempt.nearest(*attempt.exercise.goals[0], within=0.10)
    if gap > 0.10:
        return Mark(0.0, "it was never at the goal")
    return Mark.of(
        _gaps(attempt)[attempt.path[:, 0] >= at].max(), 0.105, 0.40, "it went {} m past the goal"
    )


def _gaps(attempt: Any) -> Any:
    x, y = attempt.exercise.goals[0]
    return np.hypot(attempt.path[:, 1] - x, attempt.path[:, 2] - y)
