"""Off what the robot touches before it turns: a turn would scrape along it."""

from __future__ import annotations

import math

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.footprint import Footprint

_SPEED = 0.15  # [m/s]
_WAY = 0.3  # after which it is to be free [m]


def straight_off(
    command: Velocity, pose: SE2, costmap: Costmap, footprint: Footprint, fastest: float
) -> Velocity | None:
    """Return what drives straight off, None where the command may be driven.

    The costmap's rule for a robot that collides, as one that was pushed, lets it go where it comes
    no nearer to what it touches; a turn on the spot brings its middle no nearer, but its corners.

    Args:
        command: What is to be driven.
        pose: The robot's, in the frame of the costmap.
        costmap: What is in the way.
        footprint: The robot.
        fastest: That the robot may drive now [m/s].
    """
    turns = abs(command.yaw_rate) * footprint.circumscribed_radius > abs(command.x)
    if not turns or fastest <= 0.0 or not collides(costmap, footprint, pose):
        return None
    speed = min(_SPEED, fastest)
    ways = [Velocity(v) for v in (speed, -speed)]
    steps = [_until_free(way, pose, costmap, footprint) for way in ways]
    return None if min(steps) == math.inf else ways[steps.index(min(steps))]


def _until_free(way: Velocity, pose: SE2, costmap: Costmap, footprint: Footprint) -> float:
    """Return after how many poses of a way nothing is touched, inf where it meets something."""
    arc = rollout(pose, way, _WAY / abs(way.x), costmap.frame.resolution)
    free = [k for k, at in enumerate(arc) if not collides(costmap, footprint, SE2.from_array(at))]
    hit = first_collision(costmap, footprint, arc)
    return free[0] if free and (hit is None or free[0] < hit) else math.inf
