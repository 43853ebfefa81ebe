"""Leaving what the robot touches on its costmap, by the points that scans have hit."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import KDTree

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.gap import first_contact
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.escape import lead_out, lines_off


def turn_touches(pose: SE2, turn: float, costmap: Costmap, body: Footprint) -> bool:
    """Return whether a body that turns on the spot by an angle [rad] touches a point.

    Cells tell it by half a cell only, and a circle about a body not at all: a wall beside the body
    is nearer than the corners that come round.
    """
    reach, turn = body.circumscribed_radius, math.copysign(min(abs(turn), math.tau), turn)
    points = costmap.obstacles(pose.x, pose.y, reach + costmap.frame.resolution)
    turned = np.linspace(0.0, turn, 2 + int(abs(turn) * reach / 0.01))  # a corner moves by 1 cm
    poses = np.column_stack((np.tile((pose.x, pose.y), (len(turned), 1)), pose.theta + turned))
    return bool(first_contact(poses, points, body.points) < len(poses))


def leaves(poses: Floats, costmap: Costmap, body: Footprint, error: float = 0.01) -> bool:
    """Return whether a body meets no points on a line `(N, 3)` but those it touches at its start.

    Args:
        error: Of a point, by which the body may meet it: a body that turns off a wall beside it
            swings out [m].
    """
    start, length = SE2.from_array(poses[0]), paths.length(poses)
    cell = costmap.frame.resolution
    points = costmap.obstacles(start.x, start.y, length + body.circumscribed_radius + 2.0 * cell)
    points = _with_middles(points, cell)
    points = points[~body.holds(start.inverse().apply(points))]
    inner = body.widened(-error, least=0.5)
    return bool(first_contact(poses, points, inner.points) == len(poses))


def _with_middles(points: Floats, cell: float) -> Floats:
    """Return points `(N, 2)`, one a cell at the most, and more between those of cells side by side.

    Without them the corner of a body slips through a wall between two points.
    """
    if len(points) == 0:
        return points
    near = KDTree(points).query_pairs(float(np.nextafter(2.0 * cell, 0.0)), output_type="ndarray")
    first, gaps = points[near[:, 0]], points[near[:, 1]] - points[near[:, 0]]
    parts = np.array([0.25, 0.5, 0.75])[:, None, None]
    return np.vstack([points, *(first + parts * gaps)])


def line_off(
    pose: SE2,
    costmap: Costmap,
    footprint: Footprint,
    body: Footprint,
    radius: float = 0.0,
    turn: float = 0.0,
) -> Floats:
    """Return the shortest line `(N, 3)` to where the robot is free to turn; its pose alone if none.

    It leads straight off the cells that it touches. Else in a bend past the points: a robot along
    a wall touches the wall's cells, which are coarser than the wall, and as many ahead and behind;
    its body, without padding, may leave all the same, in a wider bend the nearer the wall.

    Args:
        footprint: With padding, which is free at the end.
        body: Without.
        radius: Of the tightest bend; 0 where it turns on the spot [m].
        turn: By which it is to turn at the end [rad].
    """

    def touches(at: SE2) -> bool:
        return collides(costmap, footprint, at) or (
            turn != 0.0 and turn_touches(at, turn, costmap, body)
        )

    line = lead_out(pose, costmap, footprint, radius, touches=touches)
    if len(line) > 1 or not touches(pose):
        return line
    tightest = 1.0 / (radius or 2.0 * footprint.circumscribed_radius)
    bends = [side * tightest / wider for wider in (1.0, 2.0, 4.0, 8.0) for side in (1.0, -1.0)]
    bends.append(0.0)
    lines = list(lines_off(pose, costmap, touches, bends, reach=1.5, step=0.04))
    for error in np.linspace(0.0, 0.01, 6):  # the least of what a point may err
        if free := [line for line in lines if leaves(line, costmap, body, float(error))]:
            return min(free, key=len)
    return pose.array()[None, :]
