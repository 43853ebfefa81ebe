"""Leaving what the robot touches on its costmap, by the points that scans have hit."""

from __future__ import annotations

import itertools
import math

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.gap import first_contact
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint


def bend_off(
    pose: SE2,
    costmap: Costmap,
    footprint: Footprint,
    body: Footprint,
    radius: float = 0.0,
    reach: float = 0.5,
    step: float = 0.02,
) -> Floats:
    """Return the shortest arc `(N, 3)` to where the robot touches no cell; its pose alone if none.

    A robot that stands along a wall touches the wall's cells, which are coarser than the wall, and
    touches as many ahead and behind; its body, without padding, may leave in a bend all the same.

    Args:
        footprint: With padding, which is free at the end.
        body: Without, which meets no points on the arc but those that lie in it from the start.
        radius: Of the tightest bend; 0 where it turns on the spot [m].
        reach: Greatest length [m].
        step: Between two poses [m].
    """
    points = costmap.obstacles(pose.x, pose.y, reach + footprint.circumscribed_radius)
    points = points[~body.holds(pose.inverse().apply(points))]
    bend = 1.0 / (radius or 2.0 * footprint.circumscribed_radius)
    shortest = pose.array()[None, :]
    for turn, side in itertools.product((0.0, bend, -bend), (step, -step)):
        line = [pose]
        for k in range(1, math.floor(reach / step) + 1):
            line.append(pose @ SE2.exp(np.array([side * k, 0.0, side * k * turn])))
            if not collides(costmap, footprint, line[-1]):
                break
        poses = np.array([each.array() for each in line])
        is_shorter = len(shortest) == 1 or len(poses) < len(shortest)
        is_free = not collides(costmap, footprint, line[-1])
        if is_shorter and is_free and first_contact(poses, points, body.points) == len(poses):
            shortest = poses
    return shortest
