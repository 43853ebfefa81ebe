"""Judges of `estop`: the box's near side is at 2.25 m, and the driver turns round after 10 s."""

from typing import Any

from bringup.homework.exercise import Mark
from bringup.homework.judges import touches

__all__ = ["passes", "resumes", "says", "touches"]
_BOX, _BACK = 2.25, 10.0


def passes(attempt: Any) -> Mark:
    """Judge how near it comes."""
    ahead = attempt.path[:, 1].max()
    return Mark.of(_BOX - ahead, 1.0, 2.0, "it came no nearer than {} m")


def resumes(attempt: Any) -> Mark:
    """Judge how far it drives back."""
    path = attempt.path
    stood = path[path[:, 0] <= _BACK, 1][-1]
    return Mark.of(path[-1, 1] - stood, -0.6, 0.0, "backwards it drove {} m of 0.6")


def says(attempt: Any) -> Mark:
    """Judge what it says, by where the robot is then."""
    said = [(at, message.data) for at, message in attempt.received.get("/emergency_stop", [])]
    stops = [at for at, data in said if data]
    if not stops:
        return Mark(0.0, "nothing was said on /emergency_stop")
    path = attempt.path
    x = float(path[path[:, 0] <= stops[0] + 1e-6, 1][-1])
    if _BOX - x > 1.5:
        return Mark(0.0, f"it said stop {_BOX - x:.1f} m from the box")
    clear = any(not data for at, data in said if at > _BACK)
    return Mark(1.0) if clear else Mark(0.5, "it never said that the way is clear again")
