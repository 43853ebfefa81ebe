"""Sources of a collision monitor: scans, clouds, ranges and polygons, as points round the robot."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PolygonInstanceStamped
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.config import param
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_from_msg, scan_from_msg, seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.safety.sight import Sight, along_edges, on_arc

_UNKNOWN_INTERVAL = 0.4  # [s] before two messages have come
_PERIODS = 2.5  # of the sensor, that a message may be old
_FORMATS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""By sensor_msgs/PointField's `datatype`."""


@dataclass(frozen=True)
class WatchFrames:
    """The frames in which sources are read.

    Attributes:
        node: The node that reads.
        base: The robot's.
        odom: That in which what is seen stays put.
        correction: Whether what was seen is moved to where the robot is now.
        tolerance: By how much a transform may be older than what was seen [s].
    """

    node: ManagedNode
    base: str
    odom: str
    correction: bool
    tolerance: float

    def then(self, stamp: float) -> SE2:
        """Return `T_odom_base` at a time [s], or the newest where that is hardly older.

        Raises:
            TransformError: It is not known, or older than the tolerance.
        """
        transforms = self.node.transforms
        newest = transforms.latest_common(self.odom, self.base)
        if newest and stamp - newest > self.tolerance:
            late = f"{stamp - newest:.2f} s, over transform_tolerance of {self.tolerance:g} s"
            raise TransformError(f"{self.odom} -> {self.base} is behind what was seen by {late}")
        return transforms.lookup(self.odom, self.base, min(stamp, newest))

    def since(self, stamp: float) -> SE2:
        """Return `T_base_then`, which maps what the base saw at a time [s] to what it sees now."""
        if not self.correction:
            return IDENTITY
        return self.node.transforms.lookup(self.base, self.odom) @ self.then(stamp)


@dataclass(frozen=True)
class SourceConfig:
    """One source, by Nav2's names."""

    topic: str = param("scan", "Its topic; empty: the robot's scan.", read_only=True)
    enabled: bool = param(True, "Whether it counts.")
    source_timeout: float = param(
        -1.0, "How old a message may be; 0: any age; below 0: the node's.", unit="s", minimum=-1.0
    )


class Source:
    """A topic and what its newest message says.

    Args:
        config: Its parameters.
        frames: Where it is read.
        timeout: How old a message may be [s]; 0 for any age.
        brakes: Whether the robot slows down before that time is over, and a slow sensor has longer.

    Attributes:
        config: Its parameters.
        message: The newest; None before the first.
        tracks: Whether what moves is to be distinguished from what stands.
    """

    Config: ClassVar[type[Any]] = SourceConfig
    message_type: ClassVar[Any]

    def __init__(self, config: Any, frames: WatchFrames, timeout: float, brakes: bool) -> None:
        self.config = config
        self.tracks = False
        self._frames, self._timeout, self._brakes = frames, timeout, brakes
        self.reset()

    def subscribe(self, topic: str) -> None:
        """Listen; in the node's `configure`."""
        self._frames.node.subscribe(self.message_type, topic, self.take, qos.SENSOR_SUBSCRIPTION)

    def reset(self) -> None:
        """Forget what was seen."""
        self.message: Any | None = None
        # The shortest of the last five intervals is the sensor's period.
        self._intervals: deque[float] = deque(maxlen=5)
        self._received_at = 0.0

    def take(self, message: Any) -> None:
        """Take the newest message."""
        stamp, before = seconds(message.header.stamp), -math.inf
        if self.message is not None:
            before = seconds(self.message.header.stamp)
            self._intervals.append(stamp - before)
        if stamp > before:
            self._received_at = self._frames.node.now
        self.message = message

    @property
    def timeout(self) -> float:
        """Greatest age of a message [s], 0 for any; a slow sensor has longer if it brakes."""
        own = float(self.config.source_timeout)
        timeout = self._timeout if own < 0.0 else own
        if not self._brakes or timeout == 0.0:
            return timeout
        return max(timeout, _PERIODS * min(self._intervals, default=_UNKNOWN_INTERVAL))

    def age(self) -> float:
        """Return how old the newest message is [s], inf where there is none."""
        if self.message is None:
            return math.inf
        return self._frames.node.now - seconds(self.message.header.stamp)

    def trust(self) -> float:
        """Return which share of its speed the robot may keep: 0 where the source is silent.

        Where it brakes, by when the last new message came, not by its stamp: that is of a scan's
        first ray, a period before the scan is whole.
        """
        timeout = self.timeout
        if timeout == 0.0:
            return 1.0
        if self.age() > timeout:
            return 0.0
        if not self._brakes:
            return 1.0
        silent = self._frames.node.now - self._received_at
        # The robot slows down to a stop in the last 0.4 of the timeout.
        return min((timeout - silent) / max(0.4 * timeout, 1e-3), 1.0)

    def sight(self) -> Sight | None:
        """Return what it sees, None where its message says nothing valid.

        Raises:
            TransformError: Where the sensor or the robot is, is not known.
        """
        points = None if self.message is None else self._points(self.message)
        if self.message is None or points is None:
            return None
        return Sight.of(self._frames.since(seconds(self.message.header.stamp)).apply(points))

    def _points(self, message: Any) -> NDArray[np.float64] | None:
        """Return what a message says, `(N, 2) float64` in the base frame at its stamp [m]."""
        raise NotImplementedError

    def _mount(self, message: Any) -> SE2:
        frames, frame = self._frames, message.header.frame_id.lstrip("/")
        return frames.node.transforms.lookup(frames.base, frame)


class ScanSource(Source):
    """Laser scans; what moves in them is tracked where a zone asks for it."""

    message_type = LaserScan

    def reset(self) -> None:
        """Forget what was seen."""
        super().reset()
        self._tracker, self._moving = Tracker(REACH), Moving.nothing()

    def sight(self) -> Sight | None:
        """Return what it sees; what moves has moved on since."""
        if not self.tracks or self.message is None:
            return super().sight()
        stamp, frames = seconds(self.message.header.stamp), self._frames
        scan, T_odom_then = self._scan(self.message), frames.then(stamp)
        T_now_odom = frames.node.transforms.lookup(frames.base, frames.odom)
        if stamp != self._moving.stamp:
            self._moving = self._tracker.update(scan, T_odom_then)
        moving, turn = self._moving, SE2(0.0, 0.0, T_now_odom.theta)
        points = moving.points + (frames.node.now - stamp) * moving.velocities
        motions = turn.apply(moving.velocities)
        return Sight.of(T_now_odom.apply(points), motions, moving.speeds)

    def _scan(self, message: Any) -> Scan:
        scan = scan_from_msg(message, self._mount(message))
        transforms, frame = self._frames.node.transforms, message.header.frame_id.lstrip("/")
        return scan.mirrored() if transforms.upside_down(self._frames.base, frame) else scan

    def _points(self, message: Any) -> NDArray[np.float64]:
        scan = self._scan(message)
        ranges, angles = scan.ranges[scan.valid], scan.angles[scan.valid]
        ends = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
        return scan.T_base_sensor.apply(ends)


@dataclass(frozen=True)
class PointCloudConfig(SourceConfig):
    """A source of clouds."""

    min_height: float = param(0.05, "Least height above the base frame.", unit="m")
    max_height: float = param(0.5, "Greatest height above it.", unit="m")
    min_range: float = param(0.0, "Least distance from the sensor.", unit="m", minimum=0.0)
    use_global_height: bool = param(False, "Whether the cloud's field 'height' is the height.")


class PointCloudSource(Source):
    """Clouds of points."""

    Config: ClassVar[type[Any]] = PointCloudConfig
    message_type = PointCloud2

    def _points(self, message: Any) -> NDArray[np.float64] | None:
        config, frame = self.config, message.header.frame_id.lstrip("/")
        mount = self._frames.node.transforms.mount(self._frames.base, frame)
        # Of a cloud above a million points every second, third, ... is taken.
        cloud = cloud_from_msg(message, mount, 1_000_000)
        heights = _field(message, "height") if config.use_global_height else cloud.points[:, 2]
        if heights is None:
            return None
        far = np.linalg.norm(cloud.points - np.array(mount.position), axis=1) >= config.min_range
        kept = far & (heights >= config.min_height) & (heights <= config.max_height)
        points: NDArray[np.float64] = cloud.points[kept, :2]
        return points


def _field(message: Any, name: str) -> NDArray[np.float64] | None:
    """Return a field of those of a cloud's points that are finite, None where it has none."""
    fields = {each.name: each for each in message.fields}
    if name not in fields:
        return None
    shape, strides = (message.height, message.width), (message.row_step, message.point_step)
    order, columns = ">" if message.is_bigendian else "<", []
    for field in (fields[key] for key in ("x", "y", "z", name)):
        kind = order + _FORMATS[field.datatype]
        column: NDArray[Any] = np.ndarray(shape, kind, message.data, field.offset, strides)
        columns.append(column.ravel().astype(np.float64))
    return columns[3][np.isfinite(columns[:3]).all(axis=0)]


@dataclass(frozen=True)
class RangeConfig(SourceConfig):
    """A source of ranges."""

    obstacles_angle: float = param(
        math.pi / 180.0, "Between two points of its cone.", unit="rad", minimum=1e-4
    )


class RangeSource(Source):
    """Distances of sonars and infrared sensors: all of their cone may be an obstacle.

    Source: nav2_collision_monitor, Range::getData. A range of +inf is that of nothing (REP 117),
    where Nav2 takes the source for invalid.
    """

    Config: ClassVar[type[Any]] = RangeConfig
    message_type = Range

    def _points(self, message: Any) -> NDArray[np.float64] | None:
        if message.range == math.inf:
            return np.zeros((0, 2))
        if not message.min_range <= message.range <= message.max_range:
            return None
        step = self.config.obstacles_angle
        return self._mount(message).apply(on_arc(message.range, message.field_of_view, step))


@dataclass(frozen=True)
class PolygonSourceConfig(SourceConfig):
    """A source of polygons."""

    sampling_distance: float = param(0.1, "Between two points of an edge.", unit="m", minimum=1e-3)


class PolygonSource(Source):
    """Polygons with numbers, each kept until its time is over.

    Source: nav2_collision_monitor, PolygonSource::getData.
    """

    Config: ClassVar[type[Any]] = PolygonSourceConfig
    message_type = PolygonInstanceStamped

    def reset(self) -> None:
        """Forget what was seen."""
        super().reset()
        self._instances: dict[int, Any] = {}

    def take(self, message: Any) -> None:
        """Take a polygon; it replaces that of its number."""
        super().take(message)
        self._instances[message.polygon.id] = message

    def sight(self) -> Sight | None:
        """Return the edges of all polygons that are not too old; None where there is none."""
        now, timeout = self._frames.node.now, self.timeout
        stamps = {k: seconds(m.header.stamp) for k, m in self._instances.items()}
        fresh = [k for k in self._instances if timeout == 0.0 or now - stamps[k] <= timeout]
        self._instances = {k: self._instances[k] for k in fresh}
        if not fresh:
            return None
        each = [
            self._frames.since(stamps[k]).apply(self._points(self._instances[k])) for k in fresh
        ]
        return Sight.of(np.vstack(each))

    def _points(self, message: Any) -> NDArray[np.float64]:
        corners = np.array([(p.x, p.y) for p in message.polygon.polygon.points], dtype=np.float64)
        points = along_edges(corners.reshape(-1, 2), self.config.sampling_distance)
        return self._mount(message).apply(points)


SOURCES = PluginTypes(
    "source",
    {
        "scan": f"{__name__}:ScanSource",
        "pointcloud": f"{__name__}:PointCloudSource",
        "range": f"{__name__}:RangeSource",
        "polygon": f"{__name__}:PolygonSource",
    },
    "scan",
    key="type",
)
"""Sources by Nav2's `type`."""
