"""Sources of a collision monitor: scans, clouds, ranges, polygons and costmaps, as points."""

from __future__ import annotations

import math
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PolygonInstanceStamped
from nav2_msgs.msg import Costmap
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, duration_param, fixed, length_param, param
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import INSCRIBED, UNKNOWN
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.nodes.costmap.messages import points_from_polygon
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.nodes.costmap.sensors import WatchFrames, read_cloud, read_range, read_scan
from arjuna_nav.safety.sight import Sight, along_edges, on_arc


@dataclass(frozen=True)
class SourceConfig:
    """One source, by Nav2's names."""

    topic: str = fixed("scan", "Its topic; empty: the robot's scan.", of_robot="scan_topic")
    enabled: bool = param(True, "Whether it counts.")
    source_timeout: float = duration_param(
        -1.0, "How old a message may be; 0: any age; below 0: the node's.", minimum=-1.0
    )


class Source:
    """A topic and what its newest message says.

    Args:
        topic: What it listens to from now on.
        timeout: How old a message may be [s]; 0 for any age.
        brakes: Whether the robot slows down before that time is over, and a slow sensor has longer.

    Attributes:
        message: The newest; None before the first.
        tracks: Whether what moves is to be distinguished from what stands.
    """

    Config: ClassVar[type[Any]] = SourceConfig
    message_type: ClassVar[Any]

    def __init__(
        self, config: Any, frames: WatchFrames, topic: str, timeout: float, brakes: bool
    ) -> None:
        self.config, self.tracks = config, False
        self._frames, self._timeout, self._brakes = frames, timeout, brakes
        self.topic = frames.node.full_topic(topic)
        self._listen(topic)
        self.reset()

    def _listen(self, topic: str) -> None:
        node = self._frames.node
        node.subscribe(self.message_type, topic, self.take, qos.SENSOR_SUBSCRIPTION)

    def reset(self) -> None:
        """Forget what was seen."""
        self.message: Any | None = None
        self._read: tuple[Any, Floats | None] | None = None  # of it, by a config
        # The shortest of the last five intervals is the sensor's period.
        self._intervals: deque[float] = deque(maxlen=5)
        self._stamp, self._received_at = -math.inf, 0.0

    def take(self, message: Any) -> None:
        """Take the newest message."""
        stamp = seconds(message.header.stamp)
        if self.message is not None:
            self._intervals.append(stamp - self._stamp)
        if stamp > self._stamp:
            self._received_at = self._frames.node.now
        self.message, self._stamp, self._read = message, stamp, None

    @property
    def timeout(self) -> float:
        """Greatest age of a message [s], 0 for any; a slow sensor has longer if it brakes."""
        own = float(self.config.source_timeout)
        timeout = self._timeout if own < 0.0 else own
        # A period is taken for 0.4 s until two messages have come; 2.5 of them are tolerated.
        period = min(self._intervals, default=0.4)
        return max(timeout, 2.5 * period) if self._brakes and timeout else timeout

    @property
    def age(self) -> float:
        """Age of the newest message [s], inf where there is none."""
        return self._frames.node.now - self._stamp

    @property
    def late(self) -> bool:
        """True where its newest message is older than is allowed, or none has come."""
        return 0.0 < self.timeout < self.age

    def trust(self) -> float:
        """Return which share of its speed the robot may keep: 0 where the source is silent.

        Where it brakes, by when the last new message came, not by its stamp: that is of a scan's
        first ray, a period before the scan is whole.
        """
        timeout = self.timeout
        if self.late or not timeout or not self._brakes:
            return float(not self.late)
        silent = self._frames.node.now - self._received_at
        # The robot slows down to a stop in the last 0.4 of the timeout.
        return min((timeout - silent) / max(0.4 * timeout, 1e-3), 1.0)

    def problem(self) -> str:
        """Return that it is silent for longer than is allowed; empty where it is not."""
        if not self.config.enabled or not self.late:
            return ""
        since = "" if self.message is None else f" for {self.age:.2f} s"
        return f"no {self.config.type} has come on {self.topic}{since}"

    def sight(self) -> Sight | None:
        """Return what it sees, None where its message says nothing valid.

        Raises:
            TransformError: Where the sensor or the robot is, is not known.
            ValueError: The message lacks what the parameters ask for.
        """
        if self.message is None:
            return None
        if self._read is None or self._read[0] is not self.config:
            self._read = self.config, self._points(self.message)
        points = self._read[1]
        return None if points is None else Sight.of(self._frames.since(self._stamp).apply(points))

    def _points(self, message: Any) -> Floats | None:
        """Return what a message says, `(N, 2) float64` in the base frame at its stamp [m]."""
        raise NotImplementedError


class ScanSource(Source):
    """Laser scans; what moves in them is tracked where a zone asks for it."""

    message_type = LaserScan

    def reset(self) -> None:
        super().reset()
        self._tracker, self._moving = Tracker(REACH), Moving.nothing()
        # Of those that came while nobody looked so many are tracked: 3 s of a common lidar.
        self._untracked: deque[Any] = deque(maxlen=32)

    def take(self, message: Any) -> None:
        """Take the newest scan; the one before is yet to be tracked where nobody has looked."""
        if self.tracks and self.message is not None and self._stamp != self._moving.stamp:
            self._untracked.append(self.message)
        super().take(message)

    def sight(self) -> Sight | None:
        """Return what it sees; what comes nearer has moved on since."""
        if not self.tracks or self.message is None:
            return super().sight()
        while self._untracked:
            with suppress(TransformError, ValueError):
                self._track(self._untracked.popleft())
        if self._stamp != self._moving.stamp:
            self._track(self.message)
        T_now_odom, moving = self._frames.now(), self._moving
        turn = SE2(0.0, 0.0, T_now_odom.theta)
        points, motions = T_now_odom.apply(moving.points), turn.apply(moving.velocities)
        return Sight.of(points, motions, moving.speeds).later(self.age)

    def _track(self, message: Any) -> None:
        T_odom_then = self._frames.pose(seconds(message.header.stamp))
        scan = read_scan(self._frames, message, T_odom_then).reading
        self._moving = self._tracker.update(scan, T_odom_then)

    def _points(self, message: Any) -> Floats:
        seen = read_scan(self._frames, message)
        return seen.reading.points() if seen.is_planar else seen.ends()[:, :2]


@dataclass(frozen=True)
class PointCloudConfig(SourceConfig):
    """A source of clouds."""

    min_height: float = param(0.05, "Least height above the base frame.", unit="m")
    max_height: float = param(0.5, "Greatest height above it.", unit="m")
    min_range: float = length_param(0.0, "Least distance from the sensor.")
    use_global_height: bool = param(False, "Whether the cloud's field 'height' is the height.")


class PointCloudSource(Source):
    """Clouds of points."""

    Config: ClassVar[type[Any]] = PointCloudConfig
    message_type = PointCloud2

    def _points(self, message: Any) -> Floats:
        # Of a cloud above a million points every second, third, ... is taken.
        config, most = self.config, 1_000_000
        cloud = read_cloud(self._frames, message, most=most).reading
        kept = np.linalg.norm(cloud.points - cloud.sensor, axis=1) >= config.min_range
        points = cloud.points[:, :2]
        if config.use_global_height:
            cloud = read_cloud(self._frames, message, most=most, height="height").reading
        heights = cloud.points[:, 2]
        kept &= (heights >= config.min_height) & (heights <= config.max_height)
        seen: Floats = points[kept]
        return seen


@dataclass(frozen=True)
class RangeConfig(SourceConfig):
    """A source of ranges."""

    obstacles_angle: float = angle_param(
        math.pi / 180.0, "Between two points of its cone.", minimum=1e-4
    )


class RangeSource(Source):
    """Distances of sonars and infrared sensors: all of their cone may be an obstacle.

    Source: nav2_collision_monitor, Range::getData. A range of +inf is that of nothing (REP 117),
    where Nav2 takes the source for invalid.
    """

    Config: ClassVar[type[Any]] = RangeConfig
    message_type = Range

    def _points(self, message: Any) -> Floats | None:
        reading = read_range(self._frames, message).reading
        distance = reading.distance
        if distance == math.inf:
            return np.zeros((0, 2))
        if not reading.range_min <= distance <= reading.range_max:
            return None
        points = on_arc(distance, reading.field_of_view, self.config.obstacles_angle)
        return reading.T_base_sensor.apply(points)


@dataclass(frozen=True)
class PolygonSourceConfig(SourceConfig):
    """A source of polygons."""

    sampling_distance: float = length_param(0.1, "Between two points of an edge.", minimum=1e-3)


class PolygonSource(Source):
    """Polygons with numbers, each kept until its time is over.

    Source: nav2_collision_monitor, PolygonSource::getData.
    """

    Config: ClassVar[type[Any]] = PolygonSourceConfig
    message_type = PolygonInstanceStamped

    def reset(self) -> None:
        super().reset()
        self._instances: dict[int, Any] = {}

    def take(self, message: Any) -> None:
        super().take(message)
        self._instances[message.polygon.id] = message

    def sight(self) -> Sight | None:
        oldest = self._frames.node.now - (self.timeout or math.inf)
        stamped = {k: (seconds(m.header.stamp), m) for k, m in self._instances.items()}
        fresh = {k: stamped[k] for k in stamped if stamped[k][0] >= oldest}
        self._instances = {k: message for k, (_, message) in fresh.items()}
        each = [self._frames.since(t).apply(self._points(m)) for t, m in fresh.values()]
        return Sight.of(np.vstack(each)) if each else None

    def _points(self, message: Any) -> Floats:
        corners = points_from_polygon(message.polygon.polygon)
        points = along_edges(corners, self.config.sampling_distance)
        transforms, frame = self._frames.node.transforms, message.header.frame_id.lstrip("/")
        return transforms.lookup(self._frames.base, frame).apply(points)


@dataclass(frozen=True)
class CostmapSourceConfig(SourceConfig):
    """A source of costs."""

    cost_threshold: int = param(INSCRIBED, "Least cost of an obstacle.", minimum=0, maximum=UNKNOWN)
    treat_unknown_as_obstacle: bool = param(True, "Whether unknown cells are obstacles too.")


class CostmapSource(Source):
    """Cells of a costmap, whose publisher lives as long as anything of it comes.

    Source: nav2_collision_monitor after Jazzy, CostmapSource::getSourceData. Nav2 takes whole
    costmaps alone, so that one which publishes what changed counts as silent.
    """

    Config: ClassVar[type[Any]] = CostmapSourceConfig
    message_type = Costmap

    def _listen(self, topic: str) -> None:
        frames = self._frames
        self._reader = CostmapReader(frames.node, topic, "", frames.base, frames.tolerance)

    @property
    def late(self) -> bool:
        return self.timeout > 0.0 and self._reader.current(self.timeout) is None

    def trust(self) -> float:
        return float(not self.late)

    def problem(self) -> str:
        return self._reader.why_not_current() if self.config.enabled and self.late else ""

    def sight(self) -> Sight | None:
        costmap = self._reader.current(self.timeout or math.inf, self._frames.base)
        if costmap is None:
            return None
        costs, unknown = costmap.data, costmap.data == UNKNOWN
        kept = (costs >= self.config.cost_threshold) & ~unknown
        if self.config.treat_unknown_as_obstacle:
            kept |= unknown
        return Sight.of(costmap.frame.to_points(np.argwhere(kept)))


SOURCES = PluginTypes(
    "source",
    {
        "scan": f"{__name__}:ScanSource",
        "pointcloud": f"{__name__}:PointCloudSource",
        "range": f"{__name__}:RangeSource",
        "polygon": f"{__name__}:PolygonSource",
        "costmap": f"{__name__}:CostmapSource",
    },
    "scan",
    key="type",
)
"""Sources by Nav2's `type`."""
