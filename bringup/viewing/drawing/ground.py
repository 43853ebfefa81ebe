"""From a pointer in the picture to a place on the ground, and to the pose it draws."""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2

Point3 = tuple[float, float, float]
_SHORTEST = 0.1  # a shorter drag is a click, as in RViz [m]


def on_ground(eye: Point3, through: Point3) -> tuple[float, float] | None:
    """Return where a line of sight meets the ground, z = 0.

    Args:
        eye: Where the camera is [m].
        through: Another point of the line [m].

    Returns:
        x and y [m]; None where the line goes up or level.
    """
    down = eye[2] - through[2]
    if eye[2] <= 0.0 or down <= 1e-9:
        return None
    share = eye[2] / down
    return (
        eye[0] + share * (through[0] - eye[0]),
        eye[1] + share * (through[1] - eye[1]),
    )


def dragged_pose(start: tuple[float, float], end: tuple[float, float], heading: float) -> SE2:
    """Return the pose that a drag draws: where it began, heading for where it ended.

    Args:
        start: Where the button went down [m].
        end: Where it came up [m].
        heading: What a mere click gets [rad].
    """
    dx, dy = end[0] - start[0], end[1] - start[1]
    return SE2(*start, math.atan2(dy, dx) if math.hypot(dx, dy) >= _SHORTEST else heading)


def heading_to(robot: SE2 | None, place: tuple[float, float]) -> float:
    """Return the heading of a straight drive from the robot to a place [rad]; 0 if unknown."""
    return 0.0 if robot is None else math.atan2(place[1] - robot.y, place[0] - robot.x)
