"""What a zone round the robot is asked for, and what it does."""

from __future__ import annotations

import enum
from typing import ClassVar, Protocol

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


class Zone(Protocol):
    """A zone, made of its `Config`.

    Attributes:
        action: What it does.
    """

    action: ClassVar[Action]

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
