"""Does the robot's outline, at a pose or along a motion, meet an obstacle of a costmap?"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.grid import GridFrame
from arjuna_core.raycast import line_cells
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, UNKNOWN, Costmap
from arjuna_nav.costmap.footprint import Footprint

_CLEARANCE_EPSILON_CELLS = 1e-6  # rounding where the robot stands


def collides(costmap: Costmap, footprint: Footprint, pose: SE2) -> bool:
    """Return whether the robot at a pose (of the costmap's frame) touches a lethal cell.

    Leaving the grid counts as a collision; unknown cells do not.
    """
    return first_collision(costmap, footprint, pose.array()[None, :]) is not None


def collision_place(costmap: Costmap, footprint: Footprint, pose: SE2) -> str:
    """Return where the robot collides, for messages; and that it leaves the grid where it does."""
    outline = np.array([[pose.x, pose.y]]) if footprint.circular else footprint.at(pose)
    outside = outside_grid(costmap.frame, outline)
    return f"({pose.x:.2f}, {pose.y:.2f}){outside and ', '}{outside}"


def collision_ahead(costmap: Costmap, footprint: Footprint, poses: Floats) -> str:
    """Say where the robot collides first along poses `(N, 3)`; empty where it does not."""
    hit = first_collision(costmap, footprint, poses) if len(poses) else None
    if hit is None:
        return ""
    return f"collision ahead at {collision_place(costmap, footprint, SE2.from_array(poses[hit]))}"


def outside_grid(frame: GridFrame, points: Floats) -> str:
    """Return that points `(N, 2)` [m] lie outside a costmap's grid, and the remedy; else "".

    Source: nav2_costmap_2d, ObstacleLayer::raytraceFreespace, "out of map bounds".
    """
    if frame.inside(frame.to_cells(points)).all():
        return ""
    remedy = "'rolling_window: true' keeps it about the robot, 'width' and 'height' are its size"
    return f"outside the costmap's grid, which spans {frame.span}; {remedy}"


def footprint_cost(costmap: Costmap, footprint: Footprint, pose: SE2) -> int:
    """Return the worst cost below the robot's outline at a pose; lethal where it collides.

    Source: nav2_costmap_2d, FootprintCollisionChecker::footprintCostAtPose, which sees nothing that
    lies within the outline.
    """
    corners = costmap.frame.to_cells(footprint.at(pose))
    if collides(costmap, footprint, pose) or not costmap.frame.inside(corners).all():
        return LETHAL
    edges = zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True)
    return max(int(costmap.data[cell]) for a, b in edges for cell in line_cells(*a, *b))


def first_collision(costmap: Costmap, footprint: Footprint, poses: Floats) -> int | None:
    """Return the index of the first pose of a motion that collides, None where none does.

    The centre's cost decides where it can: 253 and above collides, below the costmap's
    `safe_cost` nothing does. Between them a polygon's edges are traced. Where the first
    pose already collides, as after a sensor's error, poses that lie no nearer to the nearest lethal
    cell than the first are let pass until the motion is free: a robot can leave, but never press
    on. Where the centre itself lies on a lethal cell, or outside the grid, the motion
    must lead out, to the nearest cell that is free for a centre: a turn on the spot does not. A
    costmap may let none pass (`leaves`).

    Args:
        costmap: Inflated costs.
        poses: `(N, 3) float64` [m, m, rad] in the costmap's frame, the present pose first.
    """
    frame = costmap.frame
    T_grid_frame = frame.origin.inverse()
    if (
        not costmap.leaves
        and len(poses) > 1
        and collides(costmap, footprint, SE2.from_array(poses[0]))
    ):
        return 0
    index = _first_collision(
        costmap.data,
        _in_cells(poses, T_grid_frame.array(), frame.resolution),
        footprint.points / frame.resolution,
        footprint.circular,
        costmap.safe_cost(footprint.circumscribed_radius),
        footprint.circumscribed_radius / frame.resolution,
    )
    return int(index) if index < len(poses) else None


@njit(cache=True)
def _in_cells(poses: Floats, transform: Floats, resolution: float) -> Floats:
    """Return poses seen through a transform `(x, y, theta)`, their points in cells."""
    result = np.empty((len(poses), 3))
    c, s = math.cos(transform[2]), math.sin(transform[2])
    for i, (x, y, theta) in enumerate(poses):
        result[i, 0] = (c * x - s * y + transform[0]) / resolution
        result[i, 1] = (s * x + c * y + transform[1]) / resolution
        result[i, 2] = theta + transform[2]
    return result


@njit(cache=True)
def _first_collision(
    data: Bytes, poses: Floats, points: Floats, circular: bool, safe_cost: int, reach: float
) -> int:
    """Return the first colliding index, or the number of poses where none collides."""
    count, allowed, first, last = len(poses), math.inf, 0.0, 0.0
    for i in range(count):
        if allowed < 0.0:
            last = -_depth_in_cells(data, poses[i], 1.0 - allowed)
            if last < allowed:
                return i
            # Distances between cells' centres fall by half a cell on a straight line outward.
            allowed = max(allowed, last - 0.5)
        if not collides_in_cells(data, poses[i], points, circular, safe_cost):
            allowed = math.inf
        elif i == 0:
            allowed = first = last = clearance_to_keep(data, poses[0], reach)
        elif allowed >= 0.0 and comes_nearer(data, poses[i], allowed):
            return i
    if allowed == math.inf:
        return count
    leads_out = first >= 0.0 or last > first + 2.0 * _CLEARANCE_EPSILON_CELLS
    return count if count > 1 and leads_out else min(count - 1, 1)


@njit(cache=True)
def clearance_to_keep(data: Bytes, pose: Floats, reach: float) -> float:
    """Return what `comes_nearer` allows on a motion that begins at a pose that collides [cells].

    That is its clearance; or where its centre is on a lethal cell or outside the grid, below 0,
    its depth: the distance to the nearest cell that is free for a centre, at most twice `reach`.
    """
    height, width = data.shape
    row, column = math.floor(pose[1]), math.floor(pose[0])
    if 0 <= row < height and 0 <= column < width and data[row, column] != LETHAL:
        return clearance_in_cells(data, pose, reach) - _CLEARANCE_EPSILON_CELLS
    return -_depth_in_cells(data, pose, 2.0 * reach) - _CLEARANCE_EPSILON_CELLS


@njit(cache=True)
def comes_nearer(data: Bytes, pose: Floats, allowed: float) -> bool:
    """Return whether a pose that collides is nearer to a lethal cell, or deeper, than allowed.

    Args:
        allowed: Clearance, or below 0 depth, by `clearance_to_keep` [cells]; infinity allows none.
    """
    if allowed < 0.0:
        return _depth_in_cells(data, pose, 1.0 - allowed) > -allowed
    return allowed == math.inf or clearance_in_cells(data, pose, allowed) < allowed


@njit(cache=True)
def collides_in_cells(
    data: Bytes, pose: Floats, points: Floats, circular: bool, safe_cost: int
) -> bool:
    """Return whether the robot at a pose `(x, y, theta)` of the grid [cells, rad] collides.

    The outline's points are in cells; below `safe_cost` at the centre no heading collides.
    """
    height, width = data.shape
    row, column = math.floor(pose[1]), math.floor(pose[0])
    if not (0 <= row < height and 0 <= column < width):
        return True
    cost = data[row, column]
    if cost != UNKNOWN and cost >= INSCRIBED:
        return True
    if circular or cost < safe_cost:
        return False
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x0 = pose[0] + c * points[-1, 0] - s * points[-1, 1]
    y0 = pose[1] + s * points[-1, 0] + c * points[-1, 1]
    for i in range(len(points)):
        x1 = pose[0] + c * points[i, 0] - s * points[i, 1]
        y1 = pose[1] + s * points[i, 0] + c * points[i, 1]
        if _edge_is_blocked(data, x0, y0, x1, y1):
            return True
        x0, y0 = x1, y1
    return False


@njit(cache=True)
def _edge_is_blocked(data: Bytes, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Sample an edge each half cell."""
    height, width = data.shape
    steps = int(2.0 * math.hypot(x1 - x0, y1 - y0)) + 1
    for k in range(steps):
        row = math.floor(y0 + (y1 - y0) * k / steps)
        column = math.floor(x0 + (x1 - x0) * k / steps)
        if not (0 <= row < height and 0 <= column < width) or data[row, column] == LETHAL:
            return True
    return False


@njit(cache=True)
def clearance_in_cells(data: Bytes, pose: Floats, reach: float) -> float:
    """Return the distance [cells] to the nearest lethal cell's centre, at most `reach`."""
    height, width = data.shape
    row, column = math.floor(pose[1]), math.floor(pose[0])
    if not (0 <= row < height and 0 <= column < width):
        return -1.0
    return _distance(data, pose, reach, LETHAL, LETHAL)


@njit(cache=True)
def _depth_in_cells(data: Bytes, pose: Floats, most: float) -> float:
    """Return the distance [cells] to the nearest cell that is known and free for a centre.

    At most `most`; more than that outside the grid and where it is not known.
    """
    height, width = data.shape
    row, column = math.floor(pose[1]), math.floor(pose[0])
    if not (0 <= row < height and 0 <= column < width) or data[row, column] == UNKNOWN:
        return most + 1.0
    return 0.0 if data[row, column] < INSCRIBED else _distance(data, pose, most, 0, INSCRIBED - 1)


@njit(cache=True)
def _distance(data: Bytes, pose: Floats, reach: float, least: int, most: int) -> float:
    """Return the distance [cells] to the nearest centre of a cell of such a cost, or `reach`."""
    height, width = data.shape
    row, column, span, best = math.floor(pose[1]), math.floor(pose[0]), int(reach) + 1, reach
    for r in range(max(row - span, 0), min(row + span + 1, height)):
        for c in range(max(column - span, 0), min(column + span + 1, width)):
            if least <= data[r, c] <= most:
                best = min(best, math.hypot(r + 0.5 - pose[1], c + 0.5 - pose[0]))
    return best
