"""Judges that many exercises share; a script imports them under its criteria's names."""

from __future__ import annotations

import numpy as np

from bringup.homework.exercise import Mark
from bringup.homework.grading import Attempt


def visits(attempt: Attempt, within: float = 0.10, bad: float = 0.35) -> Mark:
    """Return the share of goals visited in turn within a distance, up to a bad one [m]."""
    goals, total, after, why = attempt.exercise.goals, 0.0, 0.0, ""
    for number, (x, y, *_) in enumerate(goals, 1):
        gap, after = attempt.nearest(x, y, after, within)
        mark = Mark.of(gap, within, bad, f"({x:g}, {y:g}), number {number}, was passed at {{}} m")
        total += mark.share
        why = why or (mark.why if mark.share < 1.0 else "")
        if not mark.share:
            break
    return Mark(total / len(goals), why)


def closes(attempt: Attempt) -> Mark:
    """Judge where the robot ends, by the last goal."""
    x, y, *_ = attempt.exercise.goals[-1]
    gap = float(np.hypot(*(attempt.path[-1, 1:3] - (x, y))))
    driven = attempt.drive.length > 0.5  # who has not driven has not come back
    return Mark.of(gap, 0.10, 0.40, "it ended {} m away") if driven else Mark(0.0, "it never left")


def stops(attempt: Attempt) -> Mark:
    """Judge whether the robot stands in the last half second, and has driven before."""
    last = attempt.path[-25:, 1:]
    moved = float(np.hypot(*(last[-1, :2] - last[0, :2]))) + abs(float(last[-1, 2] - last[0, 2]))
    if attempt.drive.length < 0.2:
        return Mark(0.0, "it never drove")
    return Mark(float(moved < 0.01), f"in the last half second it moved {moved:.2f} m or rad")


def finishes(attempt: Attempt) -> Mark:
    """Judge whether the program came to its own end, with the robot driven."""
    if attempt.ended or attempt.finished_at is None:
        return Mark(0.0, attempt.ended or "the program still ran when time was over")
    return Mark(float(attempt.drive.length > 0.2), "it ended before anything was driven")


def touches(attempt: Attempt) -> Mark:
    """Judge what the robot touched; who has not driven has avoided nothing."""
    names = ", ".join(dict.fromkeys(attempt.drive.touched))
    if attempt.drive.length < 0.5:
        return Mark(0.0, f"it drove {attempt.drive.length:.2f} m: who stands avoids nothing")
    return Mark(float(not attempt.drive.touched), f"it touched {names}")
