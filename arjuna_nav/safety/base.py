"""What a zone round the robot is asked for, and what it does."""

from __future__ import annotations

import enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint


class Action(enum.IntEnum):
    """What is done to a velocity; the values are nav2_msgs/msg/CollisionMonitorState's."""

    DO_NOTHING = 0
    STOP = 1
    SLOWDOWN = 2
    APPROACH = 3
    LIMIT = 4


ACTIONS = {
    "stop": Action.STOP,
    "slowdown": Action.SLOWDOWN,
    "limit": Action.LIMIT,
    "approach": Action.APPROACH,
    "none": Action.DO_NOTHING,
}
"""By Nav2's `action_type`."""


class Zone(Protocol):
    """A zone, made of its `Config`, which has the fields of `ZoneConfig`.

    Attributes:
        action: What it does.
        shape: Its outline as a message brought it; None where none has come.
    """

    action: Action
    shape: Footprint | None

    def outline(self, velocity: Velocity, footprint: Footprint) -> Footprint | None:
        """Return its outline in the base frame at a velocity; None while it has none."""
        ...

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
        speeds: NDArray[np.float64] | None = None,
    ) -> float:
        """Return the part of a velocity that it allows, 0 to 1.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
            motions: Their velocities over ground, `(N, 2)` in the base frame [m/s].
            speeds: At which each may turn to the robot, `(N,)` [m/s]; its motion's if None.
        """
        ...


def inside(outline: Footprint | None, points: NDArray[np.float64]) -> int:
    """Return how many points `(N, 2)` of the base frame [m] lie within an outline."""
    return 0 if outline is None else int(outline.holds(points).sum())


def parts(velocity: Velocity) -> tuple[float, float, float]:
    """Return a velocity's forward, sideways [m/s] and turning part [rad/s]."""
    return velocity.x, velocity.y, velocity.yaw_rate
