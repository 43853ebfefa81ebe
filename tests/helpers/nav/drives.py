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
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.planners.waves.descent import descend
from arjuna_nav.planners.waves.potential import spread, traversal_costs
from arjuna_sim.model.robot import footprint
from arjuna_sim.model.world import PERSON
from bringup.lockstep import LockStep
from bringup.parameters.files import Parameters
from tests.helpers.nav.people import AWAY, PUSHED, Meetings

_BRAKED = 0.2  # after a command to stand a robot stands, and what turns its wheels is a push [s]
_STRETCH = 0.1  # on less, the encoders' ticks say little of a bend [m]
_SAMPLES = 4  # of a line of sight, a cell


class Drive:
    """A robot's drive from now on: its length and its contacts.

    Args:
        robot: In lock-step, its simulator running; `on_tick` is taken.

    Attributes:
        length: The distance driven so far [m].
        touched: Names of what was touched, in order, people among them.
        curvature: Greatest of the wheels' odometry and of what was commanded [1/m].
    """

    def __init__(self, robot: LockStep) -> None:
        self._robot = robot
        self.length, self._contacts, self._pushed = 0.0, 0, 0
        self._pushed_at, self._commanded_at = -math.inf, -math.inf
        self.touched: list[str] = []
        self.curvature, self._stretch, self._at = 0.0, (0.0, 0.0), robot.now
        self._pinned: dict[str, SE2] = {}
        self._before, self._last = frozenset(robot.sim.last.contacts), robot.sim.last
        simulator = robot.sim.simulator
        self._stage = simulator.stage
        self._walkers = [e.name for e in self._stage.entities if e.trajectory is not None]
        self._meetings = Meetings(footprint(simulator.robot.model, simulator.robot.model.urdf.root))
        robot.on_tick = self._watch

    @property
    def truth(self) -> SE2:
        """The robot's pose in the world."""
        pose: SE2 = self._robot.sim.last.truth.pose
        return pose

    @property
    def touches(self) -> int:
        """Contacts with what stands, and with people by the robot's own doing."""
        return self._contacts + self._meetings.bumped

    @property
    def hits(self) -> int:
        """Contacts with people, whoever walked, and with what they push the robot against."""
        return self._meetings.hits + self._pushed

    def _watch(self) -> None:
        last, before = self._robot.sim.last, self._last
        contacts = frozenset(last.contacts)
        self.length += last.truth.pose.distance(before.truth.pose)
        started = sorted(contacts - self._before)
        self.touched += started
        positions = [self._stage.motion(name).pose.position[:2] for name in self._walkers]
        people = np.array([(*position, PERSON[0]) for position in positions]).reshape(-1, 3)
        now, setpoint = self._robot.now, self._robot.sim.simulator.robot.setpoint
        self._commanded_at = (
            now if setpoint.x != 0.0 or setpoint.yaw_rate != 0.0 else self._commanded_at
        )
        moves = now - self._commanded_at <= _BRAKED
        tick = now - self._at
        self._bend(setpoint, last.odometry.v * tick, last.odometry.w * tick)
        self._at = now
        wheels = Velocity(before.odometry.v, yaw_rate=before.odometry.w) if moves else STILL
        self._meetings.update(last.truth.pose, wheels, people)
        self._pushed_at = now if self._meetings.touching else self._pushed_at
        if now - self._pushed_at <= PUSHED:
            self._pinned.update(dict.fromkeys(contacts, last.truth.pose))
        for name in started:
            if name not in self._walkers:
                self._count(name)
        self._last, self._before = last, contacts

    def _bend(self, setpoint: Velocity, path: float, turn: float) -> None:
        """Measure the curvature commanded, and driven over each stretch in one direction."""
        if setpoint.x != 0.0:
            self.curvature = max(self.curvature, abs(setpoint.yaw_rate / setpoint.x))
        length, angle = self._stretch if path * self._stretch[0] > 0.0 else (0.0, 0.0)
        self._stretch = length + path, angle + turn
        if abs(self._stretch[0]) >= _STRETCH:
            self.curvature = max(self.curvature, abs(self._stretch[1] / self._stretch[0]))
            self._stretch = 0.0, 0.0

    def _count(self, name: str) -> None:
        """Count a contact with what stands: its own, or what somebody pushed it into."""
        where = self._pinned.get(name)
        if where is not None and where.distance(self.truth) <= AWAY:
            self._pushed += 1
        else:
            self._contacts += 1


class FreeSpace:
    """Poses where a robot may stand on a map, and the shortest paths between them.

    Args:
        grid: The map.
        radius: The robot's inscribed radius, that no path goes nearer to a wall [m].
        clearance: From a goal to the nearest wall [m].
    """

    def __init__(self, grid: OccupancyGrid, radius: float, clearance: float) -> None:
        self.frame = grid.frame
        # between the edges of cells, not their centres
        gaps = (distance_transform_edt(grid.free()) - 0.5) * grid.frame.resolution
        self._open: NDArray[np.bool_] = gaps >= radius
        regions, _ = label(self._open)
        sizes = np.bincount(regions[self._open])
        self._cells = np.argwhere((gaps >= clearance) & (regions == int(np.argmax(sizes))))

    def draw(self, rng: np.random.Generator) -> SE2:
        """Return a random pose in the greatest connected part of the free space."""
        cell = self._cells[rng.integers(len(self._cells))]
        x, y = self.frame.to_point(int(cell[0]), int(cell[1]))
        return SE2(x, y, float(rng.uniform(-math.pi, math.pi)))

    def shortest(self, start: SE2, goal: SE2) -> float:
        """Return the length [m] of the shortest path for the radius, NaN where there is none.

        The path down a potential without costs, pulled tight between cells that see each other.
        """
        path = self.shortest_path(start, goal)
        return math.nan if path is None else float(np.hypot(*np.diff(path, axis=0).T).sum())

    def shortest_path(self, start: SE2, goal: SE2) -> NDArray[np.float64] | None:
        """Return the corners of the shortest path from the goal to the start, `(N, 2)` [m]."""
        ends = [self.frame.to_cell(pose.x, pose.y) for pose in (start, goal)]
        data = np.where(self._open, 0, LETHAL).astype(np.uint8)
        potential = spread(data, traversal_costs(), np.array([[*ends[0], 0.0]]))
        if not math.isfinite(potential[ends[1]]):
            return None
        path = descend(potential, ends[1])
        kept = path[_tight(np.isfinite(potential), path)]
        frame = self.frame
        cells: NDArray[np.float64] = (kept[:, ::-1] + 0.5) * frame.resolution
        return frame.origin.apply(cells)


@njit(cache=True)
def _tight(open_: NDArray[np.bool_], path: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the corners of a path whose ends are drawn together from both sides."""
    kept, count, last = np.zeros(len(path), np.int64), 1, len(path) - 1
    while kept[count - 1] < last:
        here, nxt = kept[count - 1], last
        while nxt > here + 1 and not _sees(open_, path[here], path[nxt]):
            nxt -= 1
        kept[count] = nxt
        count += 1
    return kept[:count]


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
