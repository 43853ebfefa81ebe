"""Small worlds and a robot for the navigation tests."""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.raycast import cast
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers import Controller, ControlResult
from arjuna_nav.costmap import Costmap, LayeredCostmap
from tests.helpers.nav.layers import costmap_config

RESOLUTION = 0.05
RADIUS = 0.25


def empty_grid(
    width: float, height: float, origin: SE2 = IDENTITY, resolution: float = RESOLUTION
) -> OccupancyGrid:
    """Return a free map of a size [m]."""
    shape = round(height / resolution), round(width / resolution)
    frame = GridFrame(resolution, shape[1], shape[0], origin)
    return OccupancyGrid(frame, np.zeros(shape, dtype=np.int8))


def block(grid: OccupancyGrid, x: float, y: float, width: float, height: float) -> None:
    """Occupy a rectangle whose lower left corner is given in grid coordinates [m]."""
    columns = slice(round(x / grid.frame.resolution), round((x + width) / grid.frame.resolution))
    rows = slice(round(y / grid.frame.resolution), round((y + height) / grid.frame.resolution))
    grid.data[rows, columns] = 100


def grid_of(
    width: float, height: float, *blocks: tuple[float, float, float, float], origin: SE2 = IDENTITY
) -> OccupancyGrid:
    """Return a map of a size [m], free but for rectangles as `block` takes them."""
    grid = empty_grid(width, height, origin)
    for rectangle in blocks:
        block(grid, *rectangle)
    return grid


def room() -> OccupancyGrid:
    """Return the 10 x 10 m room with four 0.5 m boxes, walls 0.1 m, the origin in its middle."""
    grid = empty_grid(11.0, 11.0, SE2(-5.5, -5.5))
    for x, y, width, height in (
        (0.4, 0.4, 10.2, 0.1),
        (0.4, 10.5, 10.2, 0.1),
        (0.4, 0.4, 0.1, 10.2),
        (10.5, 0.4, 0.1, 10.2),
    ):
        block(grid, x, y, width, height)
    for x, y in ((2.5, 0.0), (-1.5, 3.0), (-2.0, -2.5), (3.0, -3.0)):
        block(grid, x + 5.25, y + 5.25, 0.5, 0.5)
    return grid


def costmap_of(
    grid: OccupancyGrid,
    radius: float = RADIUS,
    inflation_radius: float = 0.55,
    track_unknown: bool = False,
    footprint: str = "[]",
) -> Costmap:
    """Return the inflated costmap of a map."""
    config = costmap_config(
        resolution=grid.frame.resolution,
        robot_radius=radius,
        footprint=footprint,
        footprint_padding=0.0,
        track_unknown_space=track_unknown,
        plugins=("static_layer", "inflation_layer"),
        inflation_layer={"inflation_radius": inflation_radius, "cost_scaling_factor": 5.0},
    )
    layered = LayeredCostmap(config)
    layered.set_map(grid)
    return layered.costmap


def scan_from(grid: OccupancyGrid, pose: SE2, beams: int = 360, range_max: float = 12.0) -> Scan:
    """Return the noiseless scan of a map from a pose."""
    in_grid = grid.frame.origin.inverse() @ pose
    increment = 2.0 * math.pi / beams
    bearings = -math.pi + increment * np.arange(beams, dtype=np.float64)
    resolution = grid.frame.resolution
    ranges = cast(
        grid.occupied(), resolution, in_grid.x, in_grid.y, bearings + in_grid.theta, range_max
    )
    return Scan(ranges + 1e-3, -math.pi, increment, 0.12, range_max)


@dataclass
class Unicycle:
    """A robot that drives as commanded after a delay, within its accelerations.

    Attributes:
        pose: Where it is.
        delay: Time from a command to its effect, in periods.
        acceleration: How fast its speed changes [m/s^2].
        angular_acceleration: How fast its turn rate changes [rad/s^2].
        steered: Whether it turns only as it rolls, by the arc that was commanded.
        trace: Every pose it had.
    """

    pose: SE2
    velocity: Velocity = field(default_factory=Velocity)
    period: float = 0.05
    delay: int = 1
    acceleration: float = 1.0
    angular_acceleration: float = 1.5
    steered: bool = False
    trace: list[SE2] = field(default_factory=list)
    _queue: deque[Velocity] = field(default_factory=deque)

    def drive(self, command: Velocity) -> None:
        """Drive one period."""
        self._queue.append(command)
        target = self._queue.popleft() if len(self._queue) > self.delay else Velocity()
        dv, dw = self.acceleration * self.period, self.angular_acceleration * self.period
        v = self.velocity.x + float(np.clip(target.x - self.velocity.x, -dv, dv))
        w = self.velocity.yaw_rate + float(
            np.clip(target.yaw_rate - self.velocity.yaw_rate, -dw, dw)
        )
        if self.steered:
            w = v * target.yaw_rate / target.x if target.x else 0.0
        self.velocity = Velocity(v, yaw_rate=w)
        self.pose = self.pose @ SE2.exp(np.array([v, 0.0, w]) * self.period)
        self.trace.append(self.pose)


def follow(
    controller: Controller, robot: Unicycle, costmap: Costmap, steps: int
) -> list[ControlResult]:
    """Drive a controller's commands for a number of periods, or until it has stood for 40.

    A failure stops the robot.
    """
    results: list[ControlResult] = []
    for k in range(steps):
        if k > 40 and all(result.velocity == STILL for result in results[-40:]):
            break
        result = controller.compute(robot.pose, robot.velocity, costmap, k * robot.period)
        results.append(result)
        robot.drive(result.velocity)
    return results


def polyline(corners: list[tuple[float, float]], final_yaw: float) -> NDArray[np.float64]:
    """Return a path along corners, a pose each 5 cm."""
    points = []
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        count = max(round(math.hypot(x1 - x0, y1 - y0) / 0.05), 1)
        ratio = np.arange(count)[:, None] / count
        points.append(np.array([x0, y0]) + ratio * np.array([x1 - x0, y1 - y0]))
    array = np.vstack([*points, [corners[-1]]])
    steps = np.diff(array, axis=0)
    yaw = np.append(np.arctan2(steps[:, 1], steps[:, 0]), final_yaw)
    return np.column_stack((array, yaw))
