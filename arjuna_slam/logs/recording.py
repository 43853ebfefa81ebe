"""Recordings: their scans with the odometry at the scans' stamps."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.bags.decoder import TRANSFORMS, DecodeError, Decoder, is_standard
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import ROS1, ROS2, BagMessage
from arjuna_core.errors import InputFileError
from arjuna_core.pose3 import Pose3
from arjuna_core.readings import scan_from_msg, seconds
from arjuna_core.ros.health.rules import scan_problem, transform_problem
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, yaw_of
from arjuna_core.transforms import TransformBuffer, TransformError

_USUAL = ("/scan", "/odom")


@dataclass(frozen=True)
class StampedTransform:
    """`T_parent_child` at a time."""

    stamp: float  # time [s]
    parent: str  # frame mapped into
    child: str  # frame mapped from
    transform: SE2  # the planar part
    mount: Pose3  # the transform in space


def scan_of(message: Any) -> tuple[Scan, str]:
    """Return a LaserScan as a scan, the sensor at the base, and its frame; or raise DecodeError."""
    problem = scan_problem(message)
    if problem is not None:
        raise DecodeError(problem)
    with np.errstate(invalid="ignore"):  # damaged bytes
        scan = scan_from_msg(message)
    return scan, message.header.frame_id.lstrip("/")


def odometry_of(message: Any) -> StampedTransform:
    """Return the pose of a nav_msgs/Odometry; raise DecodeError where its values are no pose's."""
    return _transform(message, message.pose.pose.position, message.pose.pose.orientation)


def transforms_of(message: Any) -> list[StampedTransform]:
    """Return the transforms of a tf2_msgs/TFMessage; raise DecodeError for an unusable one."""
    for problem in map(transform_problem, message.transforms):
        if problem is not None:
            raise DecodeError(problem)
    return [
        _transform(m, m.transform.translation, m.transform.rotation) for m in message.transforms
    ]


def _transform(message: Any, position: Any, q: Any) -> StampedTransform:
    parent, child = message.header.frame_id.lstrip("/"), message.child_frame_id.lstrip("/")
    try:
        pose = SE2(position.x, position.y, yaw_of(q.x, q.y, q.z, q.w))
    except ValueError as error:
        raise DecodeError(str(error)) from error
    mount = Pose3((position.x, position.y, position.z), (q.w, q.x, q.y, q.z))
    return StampedTransform(seconds(message.header.stamp), parent, child, pose, mount)


SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"
CLOUD = "sensor_msgs/msg/PointCloud2"


@dataclass(frozen=True)
class RecordingTopics:
    """The topics and frames that are read of a recording."""

    scan: str = ""  # topic of the scans; "" for the only one there is
    odometry: str = ""  # topic of the odometry; "" for /tf, or an odometry topic where /tf lacks it
    odom_frame: str = "odom"  # frame of the odometry in /tf
    # frame of the robot's base; where /tf has none of that name, that of the odometry topic's poses
    base_frame: str = "base_footprint"


class Recording:
    """The scans of a recording, a file or a folder, each with `T_odom_base` at its stamp.

    Raises:
        InputFileError: It is no recording, or has no scans or odometry; the message lists what is
            there.
    """

    def __init__(self, path: Path, topics: RecordingTopics) -> None:
        self._path = path
        self._topics = topics
        self._frames = topics.odom_frame, topics.base_frame
        self._bag = Bag(path)
        self._decoder = Decoder()
        self._problems: list[str] = []
        self._buffer = TransformBuffer()
        self._waiting: deque[tuple[Scan, str]] = deque()
        self._unpaired = 0
        self._mounts: dict[str, SE2] = {}
        self._choose()

    @property
    def problems(self) -> list[str]:
        """The parts that were skipped."""
        return [*self._problems, *self._bag.problems]

    @property
    def progress(self) -> float:
        """Share (0..1) of the recording that has been read."""
        return self._bag.share

    def _choose(self) -> None:
        """Settle on the topics, or refuse with those that there are."""
        every = self._bag.topics.items()
        clouds = ", ".join(name for name, topic in every if topic.type_name == CLOUD)
        cure = f" (play {clouds} to pointcloud_to_laserscan, and record its scan)" if clouds else ""
        self._scan = self._one(SCAN, self._topics.scan, cure)
        self._tf = {name for name, topic in every if topic.type_name in TRANSFORMS}
        for topic in sorted({self._scan} | self._tf):
            self._check(topic)
        self._odometry = ""
        self._first = self._first_transforms()
        if self._topics.odometry or self._first.try_lookup(*self._frames) is None:
            why = _missing(self._first, self._frames)
            self._odometry = self._one(ODOMETRY, self._topics.odometry, why)
            self._check(self._odometry)
            if not self._first.knows(self._frames[1]):
                self._frames = self._frames_of_odometry()

    def _check(self, name: str) -> None:
        topic = self._bag.topics[name]
        if topic.encoding not in (ROS1, ROS2):
            problem = f"{name} is encoded as '{topic.encoding}'; valid: {ROS2} (ROS 2), {ROS1}"
            raise InputFileError(self._path, problem)
        if not is_standard(topic):
            problem = f"{name} is of a type that only has the name of {topic.type_name}"
            raise InputFileError(self._path, f"{problem}; valid: its fields in ROS")

    def _one(self, kind: str, wanted: str, why: str = "") -> str:
        """Return the topic of a type to use: the wanted one, or the usual one, or the first.

        `why` is what the refusal adds where there is none.
        """
        topics = self._bag.topics
        found = sorted(name for name, topic in topics.items() if topic.type_name == kind)
        if wanted and wanted not in found:
            valid = ", ".join(found) or "none"
            raise InputFileError(self._path, f"no topic '{wanted}' of {kind}; valid: {valid}")
        if not found:
            valid = ", ".join(sorted(topics)) or "none"
            raise InputFileError(self._path, f"has no topic of {kind}{why}; its topics: {valid}")
        chosen = wanted or next((topic for topic in _USUAL if topic in found), found[0])
        if len(found) > 1 and not wanted:
            self._problems.append(f"of the topics {', '.join(found)}, {chosen} is used")
        return chosen

    def _first_transforms(self) -> TransformBuffer:
        """Return the first transforms, up to the one that connects odometry and base."""
        buffer = TransformBuffer()
        searched = 2000  # messages in which the odometry must show up
        for count, message in enumerate(self._bag.messages(self._tf.__contains__)):
            try:
                _insert(buffer, transforms_of(self._decoded(message)), message)
            except DecodeError:
                continue  # counted when it is read again
            if buffer.try_lookup(*self._frames) is not None or count > searched:
                break
        return buffer

    def _frames_of_odometry(self) -> tuple[str, str]:
        """Return the frames that the odometry's first message names, for those it leaves empty."""
        odom, base = self._frames
        for message in self._bag.messages(self._odometry.__eq__):
            try:
                named = odometry_of(self._decoded(message))
            except DecodeError:
                continue
            return named.parent or odom, named.child or base
        return odom, base

    def _decoded(self, message: BagMessage) -> object:
        return self._decoder.decode(message.topic, message.data)

    def __iter__(self) -> Iterator[tuple[Scan, SE2]]:
        """Yield scans and poses.

        Raises:
            InputFileError: Not one scan can be given a pose.
        """
        given, unread, last = 0, 0, ""
        for message in self._bag.messages({self._scan, self._odometry, *self._tf}.__contains__):
            try:
                self._take(message)
            except DecodeError as error:
                unread += 1
                last = f"{message.topic.name}: {error}"
            for pair in self._ready():
                given += 1
                yield pair
        self._unpaired += len(self._waiting)
        if unread:
            self._problems.append(f"{unread} messages could not be read; the last, of {last}")
        if given == 0:
            raise InputFileError(self._path, f"no scan can be used: {self._why(last)}")
        if self._unpaired:
            self._problems.append(f"{self._unpaired} scans have no odometry at their stamp")

    def _take(self, message: BagMessage) -> None:
        topic, decoded = message.topic.name, self._decoded(message)
        waiting_max = 1000  # scans; odometry that lags further behind is taken for missing
        if topic == self._scan:
            self._waiting.append(scan_of(decoded))
            if len(self._waiting) > waiting_max:
                self._waiting.popleft()
                self._unpaired += 1
        elif topic == self._odometry:
            odom, base = self._frames
            _insert(self._buffer, [replace(odometry_of(decoded), parent=odom, child=base)], message)
        else:
            found = transforms_of(decoded)
            if self._odometry:  # the chosen topic wins over what /tf says of the same pair
                found = [item for item in found if item.child != self._frames[1]]
            _insert(self._buffer, found, message)

    def _ready(self) -> Iterator[tuple[Scan, SE2]]:
        while self._waiting:
            scan, frame = self._waiting[0]
            pose = self._buffer.try_lookup(*self._frames, scan.stamp)
            if pose is None and not self._passed(scan.stamp):
                return
            self._waiting.popleft()
            if pose is None:
                self._unpaired += 1
            else:
                scan = replace(scan, T_base_sensor=self._mount(frame))
                yield scan.mirrored() if self._upside_down(frame) else scan, pose

    def _passed(self, stamp: float) -> bool:
        try:
            return self._buffer.latest_common(*self._frames) > stamp
        except TransformError:
            return False

    def _mount(self, frame: str) -> SE2:
        """Return a sensor frame's pose on the robot; the origin if it is unknown."""
        base = self._frames[1]
        mount = self._buffer.try_lookup(base, frame) or self._first.try_lookup(base, frame)
        if mount is None and frame not in self._mounts:
            problem = f"nothing says where '{frame}' is on '{base}': taken as its origin"
            self._problems.append(problem)
        self._mounts[frame] = mount or self._mounts.get(frame, IDENTITY)
        return self._mounts[frame]

    def _upside_down(self, frame: str) -> bool:
        try:
            return self._buffer.upside_down(self._frames[1], frame)
        except TransformError:
            return False

    def _why(self, last: str) -> str:
        if last:
            return last
        if not self._unpaired:
            return f"there is no message of {self._scan}"
        try:
            self._buffer.lookup(*self._frames)
        except TransformError as error:
            return str(error)
        return "there is no odometry at the stamps of the scans"


def _missing(buffer: TransformBuffer, frames: tuple[str, str]) -> str:
    """Return why transforms hold no odometry, with the options that name its frames."""
    try:
        buffer.lookup(*frames)
    except TransformError as error:
        return f", and of its transforms {error} (--odom-frame, --base-frame)"
    return ""


def _insert(buffer: TransformBuffer, found: list[StampedTransform], message: BagMessage) -> None:
    static = message.topic.name.endswith("tf_static")
    for item in found:
        buffer.insert(item.parent, item.child, item.stamp, item.transform, static, item.mount)
