"""One picture of a recording at a moment: map, robot, scan, paths and goals, without a viewer."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.bags.decoder import DecodeError, Decoder
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.errors import InputFileError
from arjuna_core.grid import OccupancyGrid
from arjuna_core.readings import grid_from_msg, scan_from_msg, se2_from_pose
from arjuna_core.se2 import SE2
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.messages import frame_of

_BASES = ("base_footprint", "base_link")


def _none() -> NDArray[np.float64]:
    return np.empty((0, 2))


@dataclass
class Snapshot:
    """Everything at a moment, in the frame of the map or, without one, of the odometry.

    Attributes:
        time: The moment [s].
        scan: Points of the last scan, `(N, 2)` [m].
        believed: The positions that it believed in until then, `(N, 2)` [m].
        missed: The numbers of the goals, from 1, that it is known not to have reached.
        touches: Where it was when it touched something, as far as that is known.
        true: Its true positions, by a simulator's odometry without errors, `(N, 2)` [m].
    """

    time: float = 0.0
    grid: OccupancyGrid | None = None
    scan: NDArray[np.float64] = field(default_factory=_none)
    robot: SE2 | None = None
    believed: list[tuple[float, float]] = field(default_factory=list)
    true: list[tuple[float, float]] = field(default_factory=list)
    plan: NDArray[np.float64] = field(default_factory=_none)
    goals: list[SE2] = field(default_factory=list)
    missed: frozenset[int] = frozenset()
    touches: list[SE2] = field(default_factory=list)


def snapshot_of(bag: Bag, moment: float | None = None) -> Snapshot:
    """Return a recording's state at a moment.

    Args:
        moment: Seconds from its beginning; None for its end.

    Raises:
        InputFileError: It holds no scan, map or pose.
    """
    reader = _Reader()
    end = bag.end if moment is None else bag.start + round(moment * 1e9)
    wanted = {name for name, topic in bag.topics.items() if topic.type_name in reader.takers}
    for message in bag.messages(wanted.__contains__):
        if message.time > end:
            break
        reader.found.time = (message.time - bag.start) / 1e9
        reader.take(message)
    found = reader.found
    if found.grid is None and found.robot is None and not len(found.scan):
        valid = ", ".join(sorted(bag.topics)) or "none"
        raise InputFileError(bag.path, f"shows neither map nor robot; its topics: {valid}")
    return found


class _Reader:
    def __init__(self) -> None:
        self.found = Snapshot()
        self._decoder = Decoder()
        self._frames = Frames("map")
        self.takers = {
            "tf2_msgs/msg/TFMessage": self._transforms,
            "sensor_msgs/msg/LaserScan": self._scan,
            "nav_msgs/msg/OccupancyGrid": self._map,
            "nav_msgs/msg/Odometry": self._odometry,
            "nav_msgs/msg/Path": self._path,
            "geometry_msgs/msg/PoseStamped": self._goal,
        }

    def take(self, message: BagMessage) -> None:
        try:
            decoded = self._decoder.decode(message.topic, message.data)
            self.takers[message.topic.type_name](message.topic.name, decoded)
        except (DecodeError, ValueError):
            return  # a damaged message more or less: the picture shows what can be read

    def _transforms(self, topic: str, message: Any) -> None:
        self._frames.take(message, topic.endswith("tf_static"), self.found.time)

    def _map(self, topic: str, message: Any) -> None:
        if "costmap" not in topic:
            self.found.grid = grid_from_msg(message)

    def _path(self, topic: str, message: Any) -> None:
        at = [each.pose.position for each in message.poses]
        self.found.plan = np.array([(p.x, p.y) for p in at]).reshape(-1, 2)

    def _scan(self, topic: str, message: Any) -> None:
        frame, points = frame_of(message), scan_from_msg(message).points()
        base = next((name for name in _BASES if self._frames.pose(name)), frame)
        robot, sensor = self._frames.pose(base), self._frames.pose(frame)
        if robot is None or sensor is None:
            return
        self.found.robot = robot.planar()
        _extend(self.found.believed, robot.position[0], robot.position[1])
        self.found.scan = sensor.apply(np.column_stack([points, np.zeros(len(points))]))[:, :2]

    def _odometry(self, topic: str, message: Any) -> None:
        if topic.endswith("ground_truth/odom"):
            at = message.pose.pose.position
            _extend(self.found.true, at.x, at.y)

    def _goal(self, topic: str, message: Any) -> None:
        if topic.endswith("goal_pose"):
            self.found.goals.append(se2_from_pose(message.pose))


def _extend(trail: list[tuple[float, float]], x: float, y: float, step: float = 0.05) -> None:
    """Add a point to a trail, if it is a step [m] from the last one."""
    if not trail or abs(trail[-1][0] - x) + abs(trail[-1][1] - y) > step:
        trail.append((x, y))
