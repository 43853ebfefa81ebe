"""Random scenes for all of navigation's nodes: two lidars that see different things, masks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from nav2_msgs.msg import CostmapFilterInfo
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, scan_msg, transform_msg
from arjuna_core.se2 import SE2
from bringup.parameters.files import Parameters, shipped_parameters
from bringup.scenarios.drive import desired_speed
from bringup.scenarios.space import FreeSpace
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.monitored import Monitored
from tests.helpers.nav.navigation import SUCCEEDED, PlayedRobot
from tests.helpers.nav.navigator_goals import go
from tests.helpers.ros import TICK
from tests.nav.worlds import room, scan_from

BODY = (0.225, 0.19)  # half the length and half the width of the robot [m]
COSTMAPS = ("global_costmap/global_costmap", "local_costmap/local_costmap")
_TIMEOUT = 120.0  # of a goal [s]
_REAR = SE2(-0.2, 0.0, math.pi)
_REAR_TICKS = 9  # between its scans, which come at another rate than the front lidar's
_SETTLED = 1.0  # after which a limit holds [s]


@dataclass
class Outcome:
    """Result of a scene.

    Attributes:
        reached: Whether navigation came to its goal.
        wrong: Ticks in which the robot touched something, was in a zone, or above its limit.
        held: Ticks in which a limit was in force that has had the time to be kept.
        worst: Greatest speed as a share of the limit in force.
    """

    reached: bool = False
    wrong: int = 0
    held: int = 0
    worst: float = 0.0


def touches(grid: OccupancyGrid, pose: SE2) -> bool:
    """Return whether the robot's body at a pose meets an occupied cell."""
    cells = np.argwhere(grid.occupied())
    middles = grid.frame.to_points(cells)
    near = cells[np.hypot(*(middles - (pose.x, pose.y)).T) < 0.4]
    # of each cell nine points, its corners among them
    spots = near[:, None] + np.stack(np.meshgrid(*[[-0.5, 0.0, 0.5]] * 2), -1).reshape(1, -1, 2)
    x, y = pose.inverse().apply(grid.frame.to_points(spots.reshape(-1, 2))).T
    return bool(((np.abs(x) < BODY[0]) & (np.abs(y) < BODY[1])).any())


class TwoLidars(PlayedRobot):
    """A robot whose second lidar sees another world than its first, at another rate."""

    def __init__(self, both: bool = True) -> None:
        rear = {"topic": "/rear", "clearing": True, "inf_is_valid": True}
        ranges = {"obstacle_max_range": 3.0, "raytrace_max_range": 4.0}
        heights = {"min_obstacle_height": -1.0, "max_obstacle_height": 2.0}
        sources = {"observation_sources": "scan rear", "rear": {**rear, **ranges, **heights}}
        monitor = {"observation_sources": ["scan", "rear"], "rear": {"topic": "/rear"}}
        parameters: Parameters = {name: {"obstacle_layer": sources} for name in COSTMAPS}
        super().__init__({**parameters, "collision_monitor": monitor} if both else None)
        self.rear_world = self.world
        mount = TFMessage(transforms=[transform_msg(_REAR, "base_link", "rear_link", 0.0)])
        self.bench.publish(TFMessage, "/tf_static", mount, qos.TF_STATIC)

    def _tick(self) -> None:
        super()._tick()
        if self._ticks % _REAR_TICKS == 0:
            scan = scan_from(self.rear_world, self.pose @ _REAR)
            message = scan_msg(scan, "rear_link", _REAR_TICKS * TICK)
            message.header.stamp = self._stamp()
            self.bench.publish(LaserScan, "/rear", message, qos.SENSOR_PUBLISHER)


def united(*grids: OccupancyGrid) -> OccupancyGrid:
    """Return what is occupied in any of several grids of one frame."""
    data = np.maximum.reduce([grid.data for grid in grids])
    return OccupancyGrid(grids[0].frame, data)


def cluttered(rng: np.random.Generator, start: SE2, count: int) -> OccupancyGrid:
    """Return the room with boxes beside its own, none near the start."""
    grid = room()
    for _ in range(count):
        middle, edge = rng.uniform(-4.5, 4.5, 2), rng.uniform(0.15, 0.4)
        if math.hypot(middle[0] - start.x, middle[1] - start.y) > 1.0:
            low, high = (grid.frame.to_cells((middle + s * edge / 2.0)[None])[0] for s in (-1, 1))
            grid.data[low[0] : high[0] + 1, low[1] : high[1] + 1] = 100
    return grid


def two_lidars(seed: int, both: bool = True) -> Outcome:
    """Drive to a goal among obstacles of which each lidar sees one half.

    Args:
        both: Whether both are sources; else the first alone, to see that the scene needs both.
    """
    rng = np.random.default_rng(seed)
    start = SE2(0.0, 0.0, float(rng.uniform(-math.pi, math.pi)))
    low, high = cluttered(rng, start, 12), cluttered(rng, start, 12)
    whole = united(low, high)
    ground = FreeSpace(whole, 0.3, 0.5)
    goal = _far(ground, start, rng)
    robot = TwoLidars(both)
    robot.pose, robot.world, robot.rear_world = start, low, high
    outcome = Outcome()

    def look() -> None:
        outcome.wrong += touches(whole, robot.pose)

    outcome.reached = _drive(robot, goal, room(), look)
    return outcome


def _far(ground: FreeSpace, start: SE2, rng: np.random.Generator) -> SE2:
    """Return a goal to which a robot has to drive some metres."""
    while True:
        goal = ground.draw(rng)
        if ground.shortest(start, goal) > 3.0:
            return goal


def _drive(
    robot: PlayedRobot, goal: SE2, known: OccupancyGrid, look: Any, setup: Any = None
) -> bool:
    """Bring all nodes up, drive to a goal and look after each tick; return whether it arrived."""
    try:
        robot.bring_up(*NAVIGATION_GROUP.nodes)
        robot.send_map(known)
        if setup is not None:
            setup()
        robot.run(1.0)
        sent = go(robot, goal)
        deadline = robot.now + _TIMEOUT
        while not sent.done and robot.now < deadline:
            robot.run(TICK)
            look()
        return bool(sent.done and sent.status == SUCCEEDED)
    finally:
        robot.close()


@dataclass(frozen=True)
class Mask:
    """A mask in a frame of its own.

    Attributes:
        T_map_mask: Where its frame lies in the map.
    """

    grid: OccupancyGrid
    T_map_mask: SE2

    @staticmethod
    def draw(rng: np.random.Generator) -> Mask:
        """Return an empty one of some resolution that covers the room, turned anyhow."""
        cell = float(rng.choice([0.03, 0.05, 0.08, 0.12]))
        size, turned = round(20.0 / cell), SE2(0.0, 0.0, float(rng.uniform(-0.3, 0.3)))
        frame = GridFrame(cell, size, size, turned @ SE2(-10.0, -10.0))
        own = SE2(*rng.uniform((-0.5, -0.5, -0.7), (0.5, 0.5, 0.7)).tolist())
        return Mask(OccupancyGrid(frame, np.zeros((size, size), np.int8)), own)

    def fill(self, middle: NDArray[np.float64], edges: NDArray[np.float64], value: int) -> None:
        """Write a value into a rectangle of its frame [m]."""
        rows, columns = np.indices(self.grid.frame.shape)
        cells = np.column_stack((rows.ravel(), columns.ravel()))
        off = np.abs(self.grid.frame.to_points(cells) - middle) <= edges / 2.0
        self.grid.data.ravel()[off.all(axis=1)] = value

    def at(self, pose: SE2) -> int:
        """Return its value where a robot is."""
        seen = self.T_map_mask.inverse() @ pose
        row, column = self.grid.frame.to_cell(seen.x, seen.y)
        return int(self.grid.data[row, column])

    def on(self, frame: GridFrame) -> NDArray[np.int8]:
        """Return its values at the cells of another grid of the map."""
        rows, columns = np.indices(frame.shape)
        points = frame.to_points(np.column_stack((rows.ravel(), columns.ravel())))
        cells = self.grid.frame.to_cells(self.T_map_mask.inverse().apply(points))
        return self.grid.data[cells[:, 0], cells[:, 1]].reshape(frame.shape)

    def publish(
        self, robot: PlayedRobot, name: str, kind: int, weights: tuple[float, float]
    ) -> None:
        """Publish it, its frame and the message that says what its values mean."""
        placed = transform_msg(self.T_map_mask, "map", f"{name}_frame", 0.0)
        robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[placed]), qos.TF_STATIC)
        base, multiplier = weights
        info = CostmapFilterInfo(
            type=kind, filter_mask_topic=f"/{name}", base=base, multiplier=multiplier
        )
        robot.bench.publish(CostmapFilterInfo, f"/{name}_info", info, qos.LATCHED)
        message = grid_msg(self.grid, f"{name}_frame", robot.now)
        robot.bench.publish(OccupancyGridMsg, f"/{name}", message, qos.LATCHED)


def _filtered(cls: str, name: str, *costmaps: str) -> Parameters:
    own = {"plugin": f"nav2_costmap_2d::{cls}", "filter_info_topic": f"/{name}_info"}
    return {costmap: {"filters": [name], name: own} for costmap in costmaps}


def keepout(seed: int) -> Outcome:
    """Drive to a goal round zones; of a goal in a zone navigation may say that it is none."""
    rng = np.random.default_rng(seed)
    start, mask = SE2(0.0, 0.0, float(rng.uniform(-math.pi, math.pi))), Mask.draw(rng)
    for _ in range(rng.integers(2, 7)):
        mask.fill(rng.uniform(-5.0, 5.0, 2), rng.uniform(0.4, 2.5, 2), 100)
    at = mask.T_map_mask.inverse() @ start
    mask.fill(np.array([at.x, at.y]), np.array([1.2, 1.2]), 0)
    world = room()
    free = OccupancyGrid(world.frame, np.maximum(world.data, mask.on(world.frame)))
    inside = seed % 5 == 4  # of five goals one is in a zone, or anywhere
    ground = FreeSpace(world if inside else free, 0.3, 0.5)
    goal = ground.draw(rng) if inside else _far(ground, start, rng)
    robot, outcome = PlayedRobot(_filtered("KeepoutFilter", "zones", *COSTMAPS)), Outcome()
    robot.pose, robot.world = start, world

    def look() -> None:
        outcome.wrong += mask.at(robot.pose) == 100

    outcome.reached = _drive(
        robot, goal, world, look, lambda: mask.publish(robot, "zones", 0, (0.0, 1.0))
    )
    outcome.reached |= inside
    return outcome


def speed_limits(seed: int) -> Outcome:
    """Drive to a goal through stripes of limits, in per cent or in metres per second."""
    rng = np.random.default_rng(seed)
    start, mask = SE2(0.0, 0.0, float(rng.uniform(-math.pi, math.pi))), Mask.draw(rng)
    world, percent, whole = room(), seed % 2 == 0, desired_speed(shipped_parameters())
    values = rng.choice([0, 20, 40, 60, 80], 9)
    for k, value in enumerate(values.tolist()):
        mask.fill(np.array([2.0 * k - 8.0, 0.0]), np.array([2.0, 20.0]), value)
    weights = (100.0, -1.0) if percent else (0.5, -0.005)
    goal = _far(FreeSpace(world, 0.3, 0.5), start, rng)
    robot = PlayedRobot(_filtered("SpeedFilter", "speeds", COSTMAPS[1]))
    robot.pose, robot.world, outcome = start, world, Outcome()
    since: list[float] = [math.inf, 0.0]  # the limit in force, and when it began

    def look() -> None:
        value = mask.at(robot.pose)
        limit = math.inf if value == 0 else weights[0] + weights[1] * value
        limit *= whole / 100.0 if percent else 1.0
        if limit != since[0]:
            since[:] = [limit, robot.now]
        if limit < math.inf and robot.now - since[1] > _SETTLED:
            share = abs(robot.command.x) / limit
            outcome.held, outcome.worst = outcome.held + 1, max(outcome.worst, share)
            outcome.wrong += share > 1.05

    outcome.reached = _drive(
        robot,
        goal,
        world,
        look,
        lambda: mask.publish(robot, "speeds", 1 if percent else 2, weights),
    )
    return outcome


def monitored(kind: str, seed: int) -> Outcome:
    """Drive at an obstacle that one source of the collision monitor alone sees."""
    scene = Monitored(kind)
    try:
        gap = scene.gap_at_rest(seed)
        return Outcome(reached=not math.isnan(gap), wrong=int(not 0.0 < gap < 0.5))
    finally:
        scene.robot.close()
