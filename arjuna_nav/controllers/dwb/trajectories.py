"""DWB's hot loop: simulate each sampled velocity and score the trajectory it drives.

The critics run inside the loop, one pass a trajectory, because a pass an array is four times slower
(`python -m bringup bench controller`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes, Floats
from arjuna_nav.controllers.dwb.distances import UNREACHED
from arjuna_nav.costmap.collision import collides_in_cells
from arjuna_nav.costmap.costmap import INSCRIBED, UNKNOWN


class Dynamics(NamedTuple):
    """Present velocity, accelerations along a trajectory, and steps of its simulation.

    Attributes:
        repeats_last: Whether a trajectory's last pose counts twice, as Nav2 has it.
    """

    v: float
    side: float
    w: float
    accel_v: float
    decel_v: float
    accel_side: float
    decel_side: float
    accel_w: float
    decel_w: float
    duration: float
    time_step: float
    linear_step: float
    angular_step: float
    repeats_last: bool


class Robot(NamedTuple):
    """The robot's outline in cells, as `collides_in_cells` takes it."""

    points: Floats
    circular: bool
    safe_cost: int


class Weights(NamedTuple):
    """Weights of the critics; 0 for those not in use.

    Attributes:
        sum_costs: Whether all costs below the centre of a trajectory count, else the last.
        outline: Of the worst cost below the outline.
        sum_outline: Whether all those of a trajectory count, else the last.
        path_dist: Of the end's distance from the path, a cell.
        goal_dist: Of the end's distance from the path's end, a cell.
        path_align: Of the same of a point ahead, `path_point` cells.
        goal_align: Of the same of a point ahead, `goal_point` cells.
        path_point: See path_align.
        goal_point: See goal_align.
        heading: Of the end's angle from `goal_yaw`.
        goal_yaw: The goal's heading in the grid [rad].
        heading_time: When the heading is taken [s]; below 0 at the end.
        aggregations: What counts of path_dist, goal_dist, path_align and goal_align, as an index
            of `AGGREGATIONS`, `(4,) int64`.
    """

    obstacle: float
    sum_costs: bool
    outline: float
    sum_outline: bool
    path_dist: float
    goal_dist: float
    path_align: float
    goal_align: float
    path_point: float
    goal_point: float
    heading: float
    goal_yaw: float
    heading_time: float
    aggregations: NDArray[np.int64]


class Scoring(NamedTuple):
    """The inputs of scoring.

    Attributes:
        start: `(x, y, theta)` in the grid [cells, rad].
        samples: `(N, 3) float64` of `(v, side, w)` [m/s, m/s, rad/s].
        base: `(N,) float64` scores that depend on the sample alone; inf where it is forbidden.
        resolution: Of the grid [m].
        data: `(height, width) uint8` costs.
        to_path: `(height, width) int32` distances from the path.
        to_goal: `(height, width) int32` distances from the path's end.
    """

    start: Floats
    samples: Floats
    base: Floats
    dynamics: Dynamics
    robot: Robot
    weights: Weights
    resolution: float
    data: Bytes
    to_path: NDArray[np.int32]
    to_goal: NDArray[np.int32]


@njit(cache=True)
def score_all(by: Scoring, skips: bool) -> int:
    """Return the index of the best sample, -1 where all are forbidden.

    If it skips, what cannot be the best any more is not simulated.
    """
    best, best_score = -1, math.inf
    for i in range(len(by.samples)):
        if by.base[i] == math.inf or (skips and by.base[i] >= best_score):
            continue
        cost, outline, path, goal, path_point, goal_point, off = raw_scores(by, i)
        if cost + path + goal == math.inf:
            continue
        weights = by.weights
        own = weights.obstacle * cost + weights.path_dist * path + weights.goal_dist * goal
        own = own + weights.outline * outline
        own = own + weights.path_align * path_point + weights.goal_align * goal_point
        score = by.base[i] + (own + weights.heading * off)
        if score < best_score:
            best, best_score = i, score
    return best


@njit(cache=True)
def raw_scores(by: Scoring, index: int) -> tuple[float, float, float, float, float, float, float]:
    """Return a trajectory's scores by the critics in the order of `Weights`, without the weights.

    inf where a critic forbids it, which ends the rest; 0 of those not in use.
    """
    pose, yaw, cost, outline = _drive(by, by.samples[index])
    path = goal = path_point = goal_point = off = 0.0
    if cost == math.inf:
        return cost, outline, path, goal, path_point, goal_point, off
    row, column, weights = math.floor(pose[1]), math.floor(pose[0]), by.weights
    if weights.path_dist > 0.0:
        unreached = by.to_path[row, column] >= UNREACHED
        path = math.inf if unreached else _along(by, index, by.to_path, pose, 0)
    if weights.goal_dist > 0.0:
        unreached = by.to_goal[row, column] >= UNREACHED
        goal = math.inf if unreached else _along(by, index, by.to_goal, pose, 1)
    if weights.path_align > 0.0:
        path_point = _along(by, index, by.to_path, pose, 2)
    if weights.goal_align > 0.0:
        goal_point = _along(by, index, by.to_goal, pose, 3)
    if weights.heading > 0.0:
        off = abs((weights.goal_yaw - yaw + math.pi) % (2.0 * math.pi) - math.pi)
    return cost, outline, path, goal, path_point, goal_point, off


@njit(cache=True)
def _along(
    by: Scoring,
    index: int,
    grid: NDArray[np.int32],
    end: tuple[float, float, float],
    critic: int,
) -> float:
    """Return a trajectory's value on a grid for the one of the four critics of distances.

    Source: nav2 dwb_critics, MapGridCritic::scoreTrajectory.
    """
    weights, ahead, far = by.weights, 0.0, math.inf
    if critic > 1:
        ahead = weights.path_point if critic == 2 else weights.goal_point
        far = float(by.data.shape[0] + by.data.shape[1])
    how = weights.aggregations[critic]
    if how == 0:
        return _ahead(grid, end, ahead, far)
    states, _ = trajectory(by, index)
    total = float(how - 1)
    for k in range(len(states) + by.dynamics.repeats_last):
        state = states[min(k, len(states) - 1)]
        value = _ahead(grid, (state[0], state[1], state[2]), ahead, far)
        if how == 1:
            total += value
        elif total > 0.0:
            total *= value
    return total


@njit(cache=True)
def trajectory(by: Scoring, index: int) -> tuple[Floats, float]:
    """Return a trajectory's states, the start first, and the time between two [s].

    The states are `(N, 6) float64`: pose [cells, cells, rad], then velocity [m/s, m/s, rad/s].
    """
    target, dynamics = by.samples[index], by.dynamics
    steps = _steps(target, dynamics)
    dt = dynamics.duration / steps
    states = np.empty((steps + 1, 6))
    state = (by.start[0], by.start[1], by.start[2], dynamics.v, dynamics.side, dynamics.w)
    for k in range(steps + 1):
        if k > 0:
            state = _stepped(state, target, dynamics, dt, by.resolution)
        for i in range(6):
            states[k, i] = state[i]
    return states, dt


@njit(cache=True)
def _steps(target: Floats, dynamics: Dynamics) -> int:
    """Return the number of steps of a trajectory's simulation."""
    if dynamics.time_step < math.inf:
        return int(max(math.ceil(dynamics.duration / dynamics.time_step), 1))
    travel = math.hypot(target[0], target[1]) * dynamics.duration
    turn = abs(target[2]) * dynamics.duration
    linear, angular = travel / dynamics.linear_step, turn / dynamics.angular_step
    return int(max(math.ceil(linear), math.ceil(angular), 1))


@njit(cache=True)
def _stepped(
    state: tuple[float, float, float, float, float, float],
    target: Floats,
    dynamics: Dynamics,
    dt: float,
    resolution: float,
) -> tuple[float, float, float, float, float, float]:
    """Return pose and velocity a step later."""
    x, y, theta, v, side, w = state
    v = _towards(v, target[0], dynamics.accel_v * dt, dynamics.decel_v * dt)
    side = _towards(side, target[1], dynamics.accel_side * dt, dynamics.decel_side * dt)
    w = _towards(w, target[2], dynamics.accel_w * dt, dynamics.decel_w * dt)
    c, s = math.cos(theta + 0.5 * w * dt), math.sin(theta + 0.5 * w * dt)
    x += (v * c - side * s) * dt / resolution
    y += (v * s + side * c) * dt / resolution
    return x, y, theta + w * dt, v, side, w


@njit(cache=True)
def _drive(by: Scoring, target: Floats) -> tuple[tuple[float, float, float], float, float, float]:
    """Return where a trajectory ends, the heading that counts, and its costs, inf if it collides.

    The costs are those below its centre and below its outline.
    """
    dynamics, robot, data, start = by.dynamics, by.robot, by.data, by.start
    steps, (height, width) = _steps(target, dynamics), data.shape
    dt, heading_time = dynamics.duration / steps, by.weights.heading_time
    state = (start[0], start[1], start[2], dynamics.v, dynamics.side, dynamics.w)
    total, last, yaw = 0.0, 0.0, start[2]
    edges, edge = 0.0, 0.0
    for k in range(steps):
        state = _stepped(state, target, dynamics, dt, by.resolution)
        x, y, theta = state[0], state[1], state[2]
        row, column = math.floor(y), math.floor(x)
        if not (0 <= row < height and 0 <= column < width):
            return (x, y, theta), yaw, math.inf, math.inf
        cost = data[row, column]
        if (cost >= INSCRIBED and cost != UNKNOWN) or (
            cost >= robot.safe_cost and not robot.circular and _touches(data, x, y, theta, robot)
        ):
            return (x, y, theta), yaw, math.inf, math.inf
        if by.weights.outline > 0.0:
            edge = _outline_cost(data, x, y, theta, robot.points)
            edges += edge
        last = 0.0 if cost == UNKNOWN else float(cost)
        total += last
        if heading_time < 0.0 or (k + 1) * dt <= heading_time:
            yaw = theta
    if dynamics.repeats_last:
        total += last
        edges += edge
    cost_of_centre = total if by.weights.sum_costs else last
    cost_of_outline = edges if by.weights.sum_outline else edge
    return (state[0], state[1], state[2]), yaw, cost_of_centre, cost_of_outline


@njit(cache=True)
def _outline_cost(data: Bytes, x: float, y: float, theta: float, points: Floats) -> float:
    """Return the worst known cost on the outline's edges, sampled each half cell."""
    (height, width), c, s = data.shape, math.cos(theta), math.sin(theta)
    worst = 0.0
    for i in range(len(points)):
        x0, y0 = points[i - 1, 0], points[i - 1, 1]
        dx, dy = points[i, 0] - x0, points[i, 1] - y0
        steps = int(2.0 * math.hypot(dx, dy)) + 1
        for k in range(steps):
            along, beside = x0 + dx * k / steps, y0 + dy * k / steps
            row = math.floor(y + s * along + c * beside)
            column = math.floor(x + c * along - s * beside)
            if 0 <= row < height and 0 <= column < width and data[row, column] != UNKNOWN:
                worst = max(worst, float(data[row, column]))
    return worst


@njit(cache=True)
def _touches(data: Bytes, x: float, y: float, theta: float, robot: Robot) -> bool:
    """Return whether the outline meets an obstacle; the centre's cost has not decided it."""
    pose = np.array([x, y, theta])
    hit: bool = collides_in_cells(data, pose, robot.points, robot.circular, robot.safe_cost)
    return hit


@njit(cache=True)
def _ahead(
    grid: NDArray[np.int32], pose: tuple[float, float, float], distance: float, unreached: float
) -> float:
    """Return a grid's value at a point ahead of the robot."""
    column = math.floor(pose[0] + distance * math.cos(pose[2]))
    row = math.floor(pose[1] + distance * math.sin(pose[2]))
    if not (0 <= row < grid.shape[0] and 0 <= column < grid.shape[1]):
        return unreached
    return min(float(grid[row, column]), unreached)


@njit(cache=True)
def _towards(value: float, target: float, up: float, down: float) -> float:
    """Return a velocity one step nearer to its target; slowing down has its own limit."""
    limit = up if abs(target) > abs(value) and value * target >= 0.0 else down
    return min(max(target, value - limit), value + limit)
