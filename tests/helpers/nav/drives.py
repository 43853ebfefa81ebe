"""Drives of a whole robot in lock-step, judged by the simulator's truth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.planners.descent import descend
from arjuna_nav.planners.potential import spread, traversal_costs
from bringup.lockstep import LockStep
from bringup.parameters.files import Parameters

_SAMPLES = 4  # of a line of sight, a cell


class Drive:
    """What a robot does from now on: how far it goes and what it touches.

    Args:
        robot: In lock-step, its simulator running; `on_tick` is taken.

    Attributes:
        length: The way driven so far [m].
        touches: How many contacts with the world have begun.
        touched: Names of what was touched, in order.
    """

    def __init__(self, robot: LockStep) -> None:
        self._robot = robot
        self.length, self.touches = 0.0, 0
        self.touched: list[str] = []
        self._before = frozenset(robot.sim.last.contacts)
        self._pose = self.truth
        robot.on_tick = self._watch

    @property
    def truth(self) -> SE2:
        """Where the robot is in the world."""
        pose: SE2 = self._robot.sim.last.truth.pose
        return pose

    def _watch(self) -> None:
        pose, contacts = self.truth, frozenset(self._robot.sim.last.contacts)
        self.length += pose.distance(self._pose)
        begun = sorted(contacts - self._before)
        self.touches += len(begun)
        self.touched += begun
        self._pose, self._before = pose, contacts


class Ground:
    """Where a robot may stand on a map, and how short the way between two places can be.

    Args:
        grid: The map.
        radius: The robot's inscribed radius, that no way goes nearer to a wall [m].
        clearance: From a goal to the nearest wall [m].
    """

    def __init__(self, grid: OccupancyGrid, radius: float, clearance: float) -> None:
        self.frame = grid.frame
        # between the edges of cells, not their centres
        gaps = (distance_transform_edt(grid.free()) - 0.5) * grid.frame.resolution
        self._open: NDArray[np.bool_] = gaps >= radius
        regions, _ = label(self._open)
        sizes = np.bincount(regions[self._open])
        self._places = np.argwhere((gaps >= clearance) & (regions == int(np.argmax(sizes))))

    def draw(self, rng: np.random.Generator) -> SE2:
        """Return a random pose in the greatest connected part of the free space."""
        cell = self._places[rng.integers(len(self._places))]
        x, y = self.frame.to_point(int(cell[0]), int(cell[1]))
        return SE2(x, y, float(rng.uniform(-math.pi, math.pi)))

    def shortest(self, start: SE2, goal: SE2) -> float:
        """Return the length [m] of the shortest way for the radius, NaN where there is none.

        The way down a potential without costs, pulled tight between cells that see each other.
        """
        ends = [self.frame.to_cell(pose.x, pose.y) for pose in (start, goal)]
        data = np.where(self._open, 0, LETHAL).astype(np.uint8)
        potential = spread(data, traversal_costs(), np.array([[*ends[0], 0.0]]))
        if not math.isfinite(potential[ends[1]]):
            return math.nan
        way = descend(potential, ends[1])
        return _tight(np.isfinite(potential), way) * self.frame.resolution


@njit(cache=True)
def _tight(open_: NDArray[np.bool_], way: NDArray[np.float64]) -> float:
    """Return the length [cells] of a way whose ends are drawn together from both sides."""
    length, here, last = 0.0, 0, len(way) - 1
    while here < last:
        nxt = last
        while nxt > here + 1 and not _sees(open_, way[here], way[nxt]):
            nxt -= 1
        length += math.hypot(way[nxt, 0] - way[here, 0], way[nxt, 1] - way[here, 1])
        here = nxt
    return length


@njit(cache=True)
def _sees(open_: NDArray[np.bool_], a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    count = int(math.hypot(b[0] - a[0], b[1] - a[1]) * _SAMPLES) + 1
    for k in range(count + 1):
        row = a[0] + (b[0] - a[0]) * k / count
        column = a[1] + (b[1] - a[1]) * k / count
        if not open_[math.floor(row + 0.5), math.floor(column + 0.5)]:
            return False
    return True


def placed(pose: SE2) -> Parameters:
    """Return the parameters that put the robot at a pose of the world, and AMCL there as well."""
    start = {"initial_pose.x": pose.x, "initial_pose.y": pose.y, "initial_pose.yaw": pose.theta}
    return {"sim": dict(start), "amcl": {**start, "set_initial_pose": True}}


def desired_speed(parameters: Parameters) -> float:
    """Return the speed that the controller is asked to drive [m/s]."""
    values: dict[str, Any] = parameters.get("controller_server", {})
    return float(values.get("FollowPath.desired_linear_vel", 0.5))


def files_in(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    """Return the files of a folder by patterns, in the order of the numbers in their names."""
    found = [path for pattern in patterns for path in folder.glob(pattern)]
    return sorted(found, key=lambda path: (len(path.name), path.name))
