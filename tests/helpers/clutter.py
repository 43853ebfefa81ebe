"""Differences from a map: boxes, people who walk about, walls that are gone from it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import FREE, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from tests.helpers.tours import Step, TourWorld

_BOXES, _HALF = 5, 0.25  # boxes and half their edge [m]
_PEOPLE, _RADIUS, _PACE = 3, 0.25, 0.8
_APART = 0.7  # of the robot's path from boxes, and of the robot from people [m]
_GONE, _GONE_HALF = 6, 1.0  # spots where walls are gone from the map, and half their edge [m]


def crowded(world: TourWorld, steps: list[Step], rng: np.random.Generator) -> list[Step]:
    """Return a drive among five unmapped boxes and three people, cut into its scans."""
    boxes = _boxes(world, steps, rng)
    length = _PACE * 0.1 * len(steps) + 5.0
    roads = [world.road(int(rng.choice(world.reachable)), rng, length) for _ in range(_PEOPLE)]
    walked = [0.0] * _PEOPLE
    result = []
    for step in steps:
        sensor = step.truth @ step.scan.T_base_sensor
        ranges = np.minimum(step.scan.ranges, _to_segments(sensor, step.scan, boxes))
        for k, road in enumerate(roads):
            there = _along(road, walked[k] + _PACE * 0.1)
            if math.dist(there, (step.truth.x, step.truth.y)) > _APART:
                walked[k] += _PACE * 0.1
            person = _along(road, walked[k])
            if math.dist(person, (sensor.x, sensor.y)) > 2.0 * _RADIUS:
                ranges = np.minimum(ranges, _to_circle(sensor, step.scan, person))
        result.append(replace(step, scan=replace(step.scan, ranges=ranges)))
    return result


def without_walls(grid: OccupancyGrid, rng: np.random.Generator) -> OccupancyGrid:
    """Return a map that lacks the obstacles within six squares of 2 m."""
    data = grid.data.copy()
    occupied = np.argwhere(grid.occupied())
    reach = round(_GONE_HALF / grid.frame.resolution)
    for row, column in occupied[rng.integers(len(occupied), size=_GONE)].tolist():
        patch = data[max(0, row - reach) : row + reach, max(0, column - reach) : column + reach]
        patch[patch > 0] = FREE
    return replace(grid, data=data)


def _boxes(world: TourWorld, steps: list[Step], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the edges of boxes off the robot's path, `(N, 4)`."""
    path = np.array([(step.truth.x, step.truth.y) for step in steps])
    far = [p for p in world.free_points if np.hypot(*(path - p).T).min() > _APART]
    if not far:
        return np.empty((0, 4))
    edges = []
    for k in rng.integers(len(far), size=_BOXES):
        pose = SE2(float(far[k][0]), float(far[k][1]), float(rng.uniform(0.0, math.pi)))
        corners = pose.apply(_HALF * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]))
        edges.append(np.hstack((corners, np.roll(corners, -1, axis=0))))
    return np.vstack(edges)


def _along(road: NDArray[np.float64], path: float) -> tuple[float, float]:
    reached = np.append(0.0, np.cumsum(np.hypot(*np.diff(road, axis=0).T)))
    return float(np.interp(path, reached, road[:, 0])), float(np.interp(path, reached, road[:, 1]))


def _to_segments(sensor: SE2, scan: Scan, edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the range at which each beam meets the first edge, inf where none."""
    c, s = np.cos(sensor.theta + scan.angles), np.sin(sensor.theta + scan.angles)
    ranges = np.full(len(c), np.inf)
    for x0, y0, x1, y1 in edges.tolist():
        ex, ey, qx, qy = x1 - x0, y1 - y0, x0 - sensor.x, y0 - sensor.y
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = c * ey - s * ex
            along, part = (qx * ey - qy * ex) / cross, (qx * s - qy * c) / cross
            hit = (along > 0.0) & (part >= 0.0) & (part <= 1.0)
        ranges[hit] = np.minimum(ranges[hit], along[hit])
    return ranges


def _to_circle(sensor: SE2, scan: Scan, centre: tuple[float, float]) -> NDArray[np.float64]:
    c, s = np.cos(sensor.theta + scan.angles), np.sin(sensor.theta + scan.angles)
    dx, dy = centre[0] - sensor.x, centre[1] - sensor.y
    nearest = c * dx + s * dy
    depth = _RADIUS**2 - (dx * dx + dy * dy - nearest**2)
    ranges: NDArray[np.float64] = np.where(
        (depth > 0.0) & (nearest > 0.0), nearest - np.sqrt(np.maximum(depth, 0.0)), np.inf
    )
    return ranges
