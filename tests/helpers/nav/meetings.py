"""Whom a robot meets, and who of the two walked or drove into the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint

PUSHED = 0.5
"""After somebody has touched the robot, what it touches is their doing [s]."""
AWAY = 0.15
"""Until it is so far from where it was pushed against something, it rubs along it [m]."""
_STANDS = 0.02  # slower than that, what a robot is met by has come to it [m/s]
_REBOUNDS = 0.1  # that slowly a robot that was pushed may come back by itself [m/s]
_TOUCHES, _APART = 0.005, 0.03  # between the two, when a touch begins and until it is over [m]


class Meetings:
    """Counts touches of a robot and people, who stop for nobody.

    A touch is the robot's own doing if, when it begins or while it lasts, the robot's side towards
    the person moves towards it: a robot that is at rest, or moves away, has been walked into,
    and one that was pushed may spring back.

    Args:
        corners: The robot's outline about its base `(N, 2)` [m].

    Attributes:
        met: How many touches there have been.
        bumped: How many of them were the robot's own doing.
    """

    def __init__(self, corners: NDArray[np.float64]) -> None:
        self._outline = Footprint.polygon(corners)
        self._touching: dict[int, bool] = {}
        self.met = self.bumped = 0

    @property
    def touching(self) -> bool:
        """Whether anybody touches the robot now."""
        return bool(self._touching)

    def update(self, pose: SE2, velocity: Velocity, people: NDArray[np.float64]) -> None:
        """Count who touches the robot now.

        Args:
            pose: The robot's.
            velocity: The robot's.
            people: Their middles and radii `(N, 3)` [m].
        """
        if not len(people):
            return
        seen = pose.inverse().apply(people[:, :2])
        gaps, away = self._outline.gaps(seen)
        sides = seen - gaps[:, None] * away
        for k, gap in enumerate((gaps - people[:, 2]).tolist()):
            before = self._touching.get(k)
            if gap > (_TOUCHES if before is None else _APART):
                self._touching.pop(k, None)
                continue
            x, y = sides[k]
            speed = float(away[k] @ (velocity.x - velocity.yaw_rate * y, velocity.yaw_rate * x))
            drives = speed > (_STANDS if before is None else _REBOUNDS)
            self.met += before is None
            self.bumped += drives and not before
            self._touching[k] = drives or bool(before)
