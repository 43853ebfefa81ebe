"""Recordings: their scans with the odometry at the scans' stamps."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.transforms import TransformBuffer, TransformError
from arjuna_slam.logs.messages import (
    ODOMETRY,
    ROS1,
    ROS2,
    SCAN,
    TRANSFORMS,
    MessageError,
    StampedTransform,
    is_known,
    read_odometry,
    read_scan,
    read_transforms,
)
from arjuna_slam.logs.storage import Storage

_USUAL = ("/scan", "/odom", "/tf")
_WAITING_MAX = 1000  # scans; odometry that lags further behind will not come
_LOOKED_AT = 2000  # messages of /tf in which the odometry must show up


@dataclass(frozen=True)
class RecordingTopics:
    """What is read of a recording.

    Attributes:
        scan: Topic of the scans; "" for the only one there is.
        odometry: Topic of the odometry; "" for /tf, or an odometry topic where /tf lacks it.
        odom_frame: Frame of the odometry in /tf.
        base_frame: Frame of the robot's base.
    """

    scan: str = ""
    odometry: str = ""
    odom_frame: str = "odom"
    base_frame: str = "base_footprint"


class Recording:
    """The scans of a recording, each with `T_odom_base` at its stamp.

    Args:
        path: A file that `storage` can read, or a rosbag2 folder of such files.
        topics: What to read.

    Attributes:
        problems: What was passed over.

    Raises:
        InputFileError: It is no recording, or has no scans or odometry; the message says what is
            there.
    """

    def __init__(self, path: Path, topics: RecordingTopics) -> None:
        self._path = path
        self._topics = topics
        self._frames = topics.odom_frame, topics.base_frame
        self._files = Storage(path)
        self.problems = self._files.problems
        self._buffer = TransformBuffer()
        self._waiting: deque[tuple[Scan, str]] = deque()
        self._unpaired = self._unread = 0
        self._mounts: dict[str, SE2] = {}
        self._choose()

    @property
    def progress(self) -> float:
        """Share (0..1) of the recording that has been read."""
        return self._files.progress

    def _choose(self) -> None:
        """Settle on the topics, or refuse with those that there are."""
        self._channels = self._files.channels()
        self._scan = self._one(SCAN, self._topics.scan)
        self._tf = {topic for topic, c in self._channels.items() if _type(c.kind) in TRANSFORMS}
        for topic in sorted({self._scan} | self._tf):
            self._check(topic)
        self._odometry = ""
        if self._topics.odometry or not self._tf_has_odometry():
            self._odometry = self._one(ODOMETRY, self._topics.odometry)
            self._check(self._odometry)

    def _check(self, topic: str) -> None:
        """Refuse a topic that cannot be read."""
        kind, encoding, definition = self._channels[topic]
        if encoding not in (ROS1, ROS2):
            problem = f"{topic} is encoded as '{encoding}'; valid: {ROS2} (ROS 2), {ROS1}"
            raise InputFileError(self._path, problem)
        if not is_known(_type(kind), encoding, definition):
            problem = f"{topic} is of a type that only has the name of {kind}"
            raise InputFileError(self._path, f"{problem}; valid: its fields in ROS")

    def _wanted(self) -> set[str]:
        return {self._scan} | self._tf | ({self._odometry} if self._odometry else set())

    def _one(self, kind: str, asked: str) -> str:
        """Return the topic of a type to use: the one asked for, or the usual one, or the first."""
        found = sorted(topic for topic, c in self._channels.items() if _type(c.kind) == kind)
        if asked and asked not in found:
            valid = ", ".join(found) or "none"
            raise InputFileError(self._path, f"no topic '{asked}' of {kind}; valid: {valid}")
        if not found:
            topics = ", ".join(sorted(self._channels)) or "none"
            raise InputFileError(self._path, f"has no topic of {kind}; its topics: {topics}")
        chosen = asked or next((topic for topic in _USUAL if topic in found), found[0])
        if len(found) > 1 and not asked:
            self.problems.append(f"of the topics {', '.join(found)}, {chosen} is used")
        return chosen

    def _tf_has_odometry(self) -> bool:
        """Tell whether odom -> base shows up among the first transforms."""
        buffer = TransformBuffer()
        for count, (topic, data) in enumerate(self._files.messages(self._tf)):
            try:
                _insert(buffer, self._transforms(topic, data), topic)
            except MessageError:
                continue  # counted when it is read again
            if buffer.try_lookup(*self._frames) is not None:
                return True
            if count > _LOOKED_AT:
                break
        return False

    def __iter__(self) -> Iterator[tuple[Scan, SE2]]:
        """Yield scans and poses.

        Raises:
            InputFileError: Not one scan can be given a pose.
        """
        given, last = 0, ""
        for topic, data in self._files.messages(self._wanted()):
            try:
                self._take(topic, data)
            except MessageError as error:
                self._unread += 1
                last = f"{topic}: {error}"
            for pair in self._ready():
                given += 1
                yield pair
        self._unpaired += len(self._waiting)
        if self._unread:
            self.problems.append(f"{self._unread} messages could not be read; the last, of {last}")
        if given == 0:
            raise InputFileError(self._path, f"no scan can be used: {self._why(last)}")
        if self._unpaired:
            self.problems.append(f"{self._unpaired} scans have no odometry at their stamp")

    def _take(self, topic: str, data: bytes) -> None:
        if topic == self._scan:
            scan, frame = read_scan(data, self._channels[topic].encoding)
            self._waiting.append((scan, frame))
            if len(self._waiting) > _WAITING_MAX:
                self._waiting.popleft()
                self._unpaired += 1
        elif topic == self._odometry:
            pose = read_odometry(data, self._channels[topic].encoding)
            named = replace(pose, parent=self._frames[0], child=self._frames[1])
            _insert(self._buffer, [named], topic)
        else:
            found = self._transforms(topic, data)
            if self._odometry:  # the chosen topic wins over what /tf says of the same pair
                found = [item for item in found if item.child != self._frames[1]]
            _insert(self._buffer, found, topic)

    def _transforms(self, topic: str, data: bytes) -> list[StampedTransform]:
        kind, encoding, _ = self._channels[topic]
        return read_transforms(data, encoding, _type(kind))

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
                yield scan.mirrored() if self._hangs(frame) else scan, pose

    def _passed(self, stamp: float) -> bool:
        """Whether a pose newer than a stamp is known, so that what lacks will not come."""
        try:
            return self._buffer.latest_common(*self._frames) > stamp
        except TransformError:
            return False

    def _mount(self, frame: str) -> SE2:
        """Return where a sensor's frame sits on the robot; at its origin if nothing says so."""
        mount = self._buffer.try_lookup(self._topics.base_frame, frame)
        if mount is None and frame not in self._mounts:
            base = self._topics.base_frame
            self.problems.append(
                f"nothing says where '{frame}' is on '{base}': taken as its origin"
            )
        self._mounts[frame] = mount or self._mounts.get(frame, IDENTITY)
        return self._mounts[frame]

    def _hangs(self, frame: str) -> bool:
        """Tell whether a sensor's frame is upside down on the robot."""
        try:
            return self._buffer.upside_down(self._topics.base_frame, frame)
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


def _type(kind: str) -> str:
    """Return a type's name as ROS 2 writes it."""
    return kind if kind.count("/") != 1 else kind.replace("/", "/msg/")


def _insert(buffer: TransformBuffer, found: list[StampedTransform], topic: str) -> None:
    static = topic.endswith("tf_static")
    for item in found:
        buffer.insert(item.parent, item.child, item.stamp, item.transform, static, item.upside_down)
