"""One picture of a recording at a moment: map, robot, scan, paths and goals, without a viewer."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2, yaw_of
from bringup.recording.bags.decoder import DecodeError, Decoder
from bringup.recording.bags.reader import Bag
from bringup.recording.bags.topic import BagMessage
from bringup.viewing.drawing.frames import Frames

_NANO = 1_000_000_000
_BASES = ("base_footprint", "base_link")
_STEP = 0.05  # between points of a trail [m]


@dataclass
class Still:
    """What was where, in the frame of the map or, without one, of the odometry.

    Attributes:
        time: The moment [s].
        grid: The map.
        scan: Points of the last scan, `(N, 2) float64` [m].
        robot: The robot's pose.
        believed: Where it believed to be until then, `(N, 2)` [m].
        true: Where it was, by a simulator's odometry without errors, `(N, 2)` [m].
        plan: The last path, `(N, 2)` [m].
        goals: The goals that were given.
    """

    time: float = 0.0
    grid: OccupancyGrid | None = None
    scan: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    robot: SE2 | None = None
    believed: list[tuple[float, float]] = field(default_factory=list)
    true: list[tuple[float, float]] = field(default_factory=list)
    plan: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))
    goals: list[SE2] = field(default_factory=list)


def still_of(bag: Bag, moment: float | None = None) -> Still:
    """Return what a recording shows at a moment.

    Args:
        bag: The recording.
        moment: Seconds from its beginning; None for its end.

    Raises:
        InputFileError: It holds no scan, map or pose.
    """
    reader = _Reader()
    end = bag.end if moment is None else bag.start + round(moment * _NANO)
    wanted = {name for name, topic in bag.topics.items() if topic.type_name in reader.takers}
    for message in bag.messages(wanted.__contains__):
        if message.time > end:
            break
        reader.still.time = (message.time - bag.start) / _NANO
        reader.take(message)
    still = reader.still
    if still.grid is None and still.robot is None and not len(still.scan):
        valid = ", ".join(sorted(bag.topics)) or "none"
        raise InputFileError(bag.path, f"shows neither map nor robot; its topics: {valid}")
    return still


class _Reader:
    """Gathers a still, message by message."""

    def __init__(self) -> None:
        self.still = Still()
        self._decoder = Decoder()
        self._frames = Frames("map")
        self.takers = {
            "tf2_msgs/msg/TFMessage": self._transforms,
            "sensor_msgs/msg/LaserScan": self._scan,
            "nav_msgs/msg/OccupancyGrid": self._grid,
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
        static = topic.endswith("tf_static")
        for each in message.transforms:
            shift, turn = each.transform.translation, each.transform.rotation
            pose = Pose3((shift.x, shift.y, shift.z), (turn.w, turn.x, turn.y, turn.z))
            names = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
            self._frames.insert(*names, self.still.time, pose, static)

    def _scan(self, topic: str, message: Any) -> None:
        base = next((name for name in _BASES if self._frames.pose(name)), message.header.frame_id)
        robot, sensor = self._frames.pose(base), self._frames.pose(message.header.frame_id)
        if robot is None or sensor is None:
            return
        self.still.robot = SE2(*robot.position[:2], robot.rpy()[2])
        _extend(self.still.believed, robot.position[0], robot.position[1])
        ranges = np.asarray(message.ranges, dtype=np.float64)
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        good = (ranges >= message.range_min) & (ranges <= message.range_max)
        flat = ranges[good] * np.stack([np.cos(angles[good]), np.sin(angles[good])])
        points = np.stack([*flat, np.zeros(good.sum())], axis=1)
        self.still.scan = sensor.apply(points)[:, :2]

    def _grid(self, topic: str, message: Any) -> None:
        if "costmap" in topic:
            return
        info = message.info
        frame = GridFrame(float(info.resolution), info.width, info.height, _planar(info.origin))
        data = np.asarray(message.data, dtype=np.int8).reshape(frame.shape)
        self.still.grid = OccupancyGrid(frame, data)

    def _odometry(self, topic: str, message: Any) -> None:
        if topic.endswith("ground_truth/odom"):
            place = message.pose.pose.position
            _extend(self.still.true, place.x, place.y)

    def _path(self, topic: str, message: Any) -> None:
        rows = [(each.pose.position.x, each.pose.position.y) for each in message.poses]
        self.still.plan = np.array(rows, dtype=np.float64).reshape(-1, 2)

    def _goal(self, topic: str, message: Any) -> None:
        if topic.endswith("goal_pose"):
            self.still.goals.append(_planar(message.pose))


def _extend(trail: list[tuple[float, float]], x: float, y: float) -> None:
    if not trail or abs(trail[-1][0] - x) + abs(trail[-1][1] - y) > _STEP:
        trail.append((x, y))


def _planar(pose: Any) -> SE2:
    turn = pose.orientation
    return SE2(pose.position.x, pose.position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))
