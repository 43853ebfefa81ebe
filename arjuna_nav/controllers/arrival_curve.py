"""The way into a goal on a curve that ends at its heading, where there is room beside the path."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.graceful.control_law import approach
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint

_LAW = np.array([1.5, 1.5, 0.0, 1.0])
"""k_phi, k_delta, beta, lambda: soonest there, of those that come exactly to the end though the
robot feels a command late, its turn rate needs time to change and its wheels drift outwards."""

_SHARE = 0.7  # of the greatest yaw rate: by more, wheels that turn while they drive drift
_NEAREST = 0.02  # to the end, below it the distance says nothing [m]
_ROOM = 0.05  # beside the robot all along the curve [m]


class ArrivalCurve:
    """Steers onto a curve that ends at a goal's heading, or at part of a turn to it.

    Args:
        footprint: The robot.
        rate: Greatest yaw rate [rad/s].
        most: Greatest angle between the direction the goal lies in and the heading at the curve's
            end; what is more is left to a turn on the spot [rad].
        latency: From a command to the motion that is measured [s].

    Source: Park and Kuipers, A smooth control law for graceful motion of differential wheeled
        mobile robots in 2D environment, ICRA 2011.
    """

    def __init__(self, footprint: Footprint, rate: float, most: float, latency: float) -> None:
        self._footprint = footprint
        self._rate = _SHARE * rate
        self._most = most
        self._latency = latency
        self._end: SE2 | None = None

    @property
    def active(self) -> bool:
        """Whether there is a curve."""
        return self._end is not None

    def reset(self) -> None:
        """Forget the curve: the goal is another."""
        self._end = None

    def compute(
        self, pose: SE2, goal: SE2, velocity: Velocity, costmap: Costmap, speed: float
    ) -> Velocity | None:
        """Return what drives along the curve, None where something is in its way.

        Args:
            pose: The robot's, in the costmap's frame.
            goal: Where to arrive.
            velocity: As measured.
            costmap: What is in the way.
            speed: How fast to drive now [m/s].
        """
        felt = self._felt(pose, velocity)
        if self._end is None:
            sight = math.atan2(goal.y - felt.y, goal.x - felt.x)
            turn = min(max(wrap(goal.theta - sight), -self._most), self._most)
            self._end = SE2(goal.x, goal.y, sight + turn)
        limits = np.array([0.0, speed, speed, self._rate])
        target, spacing = (felt.inverse() @ self._end).array(), costmap.frame.resolution
        seen, v, w = approach(target, _LAW, limits, spacing)
        if not self._free(pose, felt, seen, costmap):
            self._end = None
            return None
        return Velocity(v, yaw_rate=w)

    def last(self, pose: SE2, velocity: Velocity, v: float) -> float:
        """Return the yaw rate of the last bit, where the law would turn ever faster [rad/s].

        It lies between the arc that comes to the place and the one that comes to the heading.

        Args:
            pose: The robot's.
            velocity: As measured.
            v: How fast it is to drive [m/s].
        """
        assert self._end is not None
        seen = self._felt(pose, velocity).inverse() @ self._end
        distance = max(math.hypot(seen.x, seen.y), _NEAREST)
        bearing = math.atan2(seen.y, max(seen.x, _NEAREST))
        return v * (bearing + 0.5 * wrap(seen.theta)) / distance

    def _felt(self, pose: SE2, velocity: Velocity) -> SE2:
        """Return where the robot is when it feels the command."""
        return pose @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * self._latency)

    def _free(self, pose: SE2, felt: SE2, seen: NDArray[np.float64], costmap: Costmap) -> bool:
        """Tell whether there is room all along the curve, and it ends at the goal."""
        assert self._end is not None
        last = felt @ SE2.from_array(seen[-1])
        if last.distance(self._end) > 2.0 * costmap.frame.resolution:
            return False
        poses = np.column_stack((felt.apply(seen[:, :2]), felt.theta + seen[:, 2]))
        poses = np.vstack((pose.array(), poses))
        cells = costmap.frame.to_cells(poses[:, :2])
        if not costmap.frame.inside(cells).all():
            return False
        if costmap.clearances[costmap.data[cells[:, 0], cells[:, 1]]].min() < _ROOM:
            return False
        return first_collision(costmap, self._footprint, poses) is None
