"""Leaving what the robot touches on its costmap, by the points that scans have hit."""

from __future__ import annotations

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.gap import first_contact
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.escape import lines_off


def bend_off(
    pose: SE2, costmap: Costmap, footprint: Footprint, body: Footprint, radius: float = 0.0
) -> Floats:
    """Return the shortest arc `(N, 3)` to where the robot touches no cell; its pose alone if none.

    A robot that stands along a wall touches the wall's cells, which are coarser than the wall, and
    touches as many ahead and behind; its body, without padding, may leave in a bend all the same.

    Args:
        footprint: With padding, which is free at the end.
        body: Without, which meets no points on the arc but those that lie in it from the start.
        radius: Of the tightest bend; 0 where it turns on the spot [m].
    """
    reach = 0.5  # greatest length [m]
    points = costmap.obstacles(pose.x, pose.y, reach + footprint.circumscribed_radius)
    points = points[~body.holds(pose.inverse().apply(points))]
    bend = radius or 2.0 * footprint.circumscribed_radius
    lines = lines_off(pose, costmap, footprint, bend, reach)
    free = (line for line in lines if first_contact(line, points, body.points) == len(line))
    return min(free, key=len, default=pose.array()[None, :])
