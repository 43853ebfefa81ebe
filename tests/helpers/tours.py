"""Drives through our worlds: what the robot saw, where it was, and what its odometry said."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion, distance_transform_edt, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.world_file import load_world
from arjuna_sim.inputs import named_robot
from arjuna_sim.simulation import Simulation, solo
from tests.slam.slam_room import ranges_at

_ROOT = Path(__file__).resolve().parents[2]
_RESOLUTION = 0.05
_MARGIN = 0.4  # of the map around the world [m]
_STEP_CELLS = 4  # of the road map
_CLEARANCE = 0.35  # of roads from walls [m]
_SPEED, _TURN = 0.5, 1.0
_LOOKAHEAD = 0.5
_SCAN_TICKS = 5  # from one scan to the next


@dataclass(frozen=True)
class Step:
    """One scan of a drive.

    Attributes:
        odometry: Pose of the base by its wheels.
    """

    truth: SE2
    odometry: SE2
    scan: Scan


class TourWorld:
    """One of our worlds, its map from its true surfaces, and roads through it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._robot = named_robot("", "")
        self._world = load_world(_ROOT / "worlds" / f"{name}.world")
        surfaces = self._simulator(0, SE2()).robot.surfaces()
        self.map = true_map(surfaces)
        self.clearance: NDArray[np.float64] = distance_transform_edt(self.map.free()) * _RESOLUTION
        self._roads()

    def _simulator(self, seed: int, spawn: SE2) -> Simulation:
        rng = np.random.default_rng(seed)
        return Simulation(solo(self._robot, spawn), self._world, SimulatorConfig(), rng)

    def _roads(self) -> None:
        """Connect free points on a coarse grid; a road is the longer the nearer it is to walls."""
        coarse = self.clearance[::_STEP_CELLS, ::_STEP_CELLS]
        height, width = coarse.shape
        number = np.full(coarse.shape, -1, np.int64)
        open_ = coarse >= _CLEARANCE
        number[open_] = np.arange(open_.sum())
        rows, columns, lengths = [], [], []
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a = number[: height - dy, max(0, -dx) : width - max(0, dx)]
            b = number[dy:, max(0, dx) : width + min(0, dx)]
            both = (a >= 0) & (b >= 0)
            rows.append(a[both])
            columns.append(b[both])
            near = coarse[open_][a[both]]
            lengths.append(math.hypot(dx, dy) * (1.0 + 0.3 / near))
        row, column, length = (np.concatenate(part) for part in (rows, columns, lengths))
        size = int(open_.sum())
        self._graph = coo_array((length, (row, column)), shape=(size, size)).tocsr()
        self.free_points = self.map.frame.to_points(np.argwhere(open_) * _STEP_CELLS)
        group = label(open_, np.ones((3, 3)))[0]
        sizes = np.bincount(group[open_])
        self.reachable = np.flatnonzero(group[open_] == int(np.argmax(sizes)))

    def road(self, start: int, rng: np.random.Generator, length: float) -> NDArray[np.float64]:
        """Return points `(N, 2)` [m] of a path over random goals, as long as asked for [m]."""
        path, here = [self.free_points[start]], start
        total = 0.0
        while total < length:
            goal = int(rng.choice(self.reachable))
            before = self._before(here)
            leg = [goal]
            while leg[-1] != here:
                leg.append(int(before[leg[-1]]))
            path += [self.free_points[k] for k in leg[-2::-1]]
            here = goal
            total = float(np.hypot(*np.diff(np.array(path), axis=0).T).sum())
        return np.array(path)

    def _before(self, start: int) -> NDArray[np.int32]:
        """Return of each point the one before it on the shortest path from `start`."""
        search: Any = dijkstra  # its stubs, where installed, take no Python integer
        before: NDArray[np.int32] = search(
            self._graph, directed=False, indices=start, return_predecessors=True
        )[1]
        return before

    def drive(self, seed: int, seconds: float) -> list[Step]:
        """Drive a random path in the simulator, a scan each 0.1 s."""
        rng = np.random.default_rng(seed)
        start = int(rng.choice(self.reachable))
        path = self.road(start, rng, _SPEED * seconds + 1.0)
        x, y = path[0].tolist()
        spawn = SE2(x, y, float(rng.uniform(-math.pi, math.pi)))
        simulator = self._simulator(seed, spawn)
        steps: list[Step] = []
        ahead, pose = 0, spawn
        for _ in range(round(seconds / simulator.config.tick)):
            while ahead < len(path) - 1 and math.dist(path[ahead], (pose.x, pose.y)) < _LOOKAHEAD:
                ahead += 1
            seen = simulator.drive(_towards(pose, path[ahead]))
            pose = seen.truth.pose
            if seen.scan is not None:
                steps.append(Step(pose, seen.odometry.T_odom_base, seen.scan))
        simulator.close()
        return steps


def true_map(surfaces: NDArray[np.float64]) -> OccupancyGrid:
    """Return the map a perfect mapper would make: one cell of surface, unknown behind it.

    Args:
        surfaces: Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m].
    """
    ends = surfaces.reshape(-1, 2)
    low, high = ends.min(axis=0) - _MARGIN, ends.max(axis=0) + _MARGIN
    width, height = (np.ceil((high - low) / _RESOLUTION)).astype(int).tolist()
    x, y = (round(float(v) - 0.017, 3) for v in low)  # aligned with nothing
    frame = GridFrame(_RESOLUTION, width, height, SE2(x, y))
    data = np.full(frame.shape, FREE, np.int8)
    for x0, y0, x1, y1 in surfaces.tolist():
        ratio = np.linspace(0.0, 1.0, 2 + int(math.hypot(x1 - x0, y1 - y0) / 0.005))
        points = np.column_stack((x0 + ratio * (x1 - x0), y0 + ratio * (y1 - y0)))
        cells = frame.to_cells(points)
        data[cells[:, 0], cells[:, 1]] = OCCUPIED
    regions = label(data == FREE)[0]
    inside = np.bincount(regions[(regions > 0) & (regions != regions[0, 0])]).argmax()
    data[(regions != inside) & (data != OCCUPIED)] = UNKNOWN
    buried = binary_erosion(data != FREE, np.ones((3, 3), bool))
    data[buried & (data == OCCUPIED)] = UNKNOWN
    return OccupancyGrid(frame, data)


def _towards(pose: SE2, target: NDArray[np.float64]) -> Velocity:
    bearing = math.atan2(target[1] - pose.y, target[0] - pose.x)
    off = wrap(bearing - pose.theta)
    if math.dist(target, (pose.x, pose.y)) < 0.1:
        return Velocity()
    turn = max(-_TURN, min(_TURN, 2.0 * off))
    return Velocity(_SPEED * max(0.0, math.cos(off)) ** 3, yaw_rate=turn)


def with_odometry(steps: list[Step], kind: str, rng: np.random.Generator) -> list[Step]:
    """Return a drive with other odometry.

    Args:
        kind: `wheels`, the simulated skid-steer robot's own; `perfect`; `noisy`, wrong by 5 % of
            the distance and 8 % of the turn, half of it constant; `slipping`, the wheels, which
            spin for a second in six and then count 30 % too much.
    """
    if kind == "wheels":
        return steps
    scale = 1.0 + rng.choice([-1.0, 1.0], 3) * (0.05, 0.05, 0.08)
    odometry, result = steps[0].odometry, [steps[0]]
    for k, (a, b) in enumerate(pairwise(steps)):
        true = (a.truth.inverse() @ b.truth).array()
        if kind == "noisy":
            true *= scale + rng.normal(0.0, (0.05, 0.05, 0.08))
        elif kind == "slipping":
            true = (a.odometry.inverse() @ b.odometry).array() * (1.3 if k % 60 < 10 else 1.0)
        odometry = odometry @ SE2.from_array(true)
        result.append(replace(b, odometry=odometry))
    return result


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
        ranges = np.minimum(step.scan.ranges, ranges_at(boxes, sensor, step.scan.angles))
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


def _to_circle(sensor: SE2, scan: Scan, centre: tuple[float, float]) -> NDArray[np.float64]:
    c, s = np.cos(sensor.theta + scan.angles), np.sin(sensor.theta + scan.angles)
    dx, dy = centre[0] - sensor.x, centre[1] - sensor.y
    nearest = c * dx + s * dy
    depth = _RADIUS**2 - (dx * dx + dy * dy - nearest**2)
    ranges: NDArray[np.float64] = np.where(
        (depth > 0.0) & (nearest > 0.0), nearest - np.sqrt(np.maximum(depth, 0.0)), np.inf
    )
    return ranges
