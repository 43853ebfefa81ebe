"""What a collision monitor sees: scans, clouds, ranges and polygons, as points round the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from geometry_msgs.msg import PolygonInstanceStamped
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan, PointCloud2, Range

from arjuna_core.config import param
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros.convert import scan_from_msg, seconds
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.moving.tracker import REACH, Moving, Tracker
from arjuna_nav.nodes.safety.clouds import cloud_points
from arjuna_nav.nodes.safety.source import Sight, Source, SourceConfig
from arjuna_nav.safety.points import along_edges, on_arc


class ScanSource(Source):
    """Laser scans; what moves in them is told from what stands where a zone asks for it."""

    message_type = LaserScan

    def reset(self) -> None:
        """Forget what was seen."""
        super().reset()
        self._tracker, self._moving = Tracker(REACH), Moving.nothing()

    def sight(self) -> Sight | None:
        """Return what it sees; what moves has moved on since.

        Raises:
            TransformError: Where the sensor or the robot is, is not known.
        """
        if not self.tracks or self.message is None:
            return super().sight()
        stamp, frames = seconds(self.message.header.stamp), self._frames
        scan, T_odom_then = self._scan(self.message), frames.then(stamp)
        T_now_odom = frames.node.transforms.lookup(frames.base, frames.odom)
        if stamp != self._moving.stamp:
            self._moving = self._tracker.update(scan, T_odom_then)
        moving, turn = self._moving, SE2(0.0, 0.0, T_now_odom.theta)
        points = moving.points + (frames.node.now - stamp) * moving.velocities
        return Sight(T_now_odom.apply(points), turn.apply(moving.velocities), moving.speeds)

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
        frame = message.header.frame_id.lstrip("/")
        mount = self._frames.node.transforms.mount(self._frames.base, frame)
        return cloud_points(message, mount, self.config)


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
        """Return the edges of all polygons that are not too old; None where there is none.

        Raises:
            TransformError: Where their frame or the robot is, is not known.
        """
        now, timeout = self._frames.node.now, self.timeout
        stamps = {k: seconds(m.header.stamp) for k, m in self._instances.items()}
        fresh = [k for k in self._instances if timeout == 0.0 or now - stamps[k] <= timeout]
        self._instances = {k: self._instances[k] for k in fresh}
        if not fresh:
            return None
        each = [
            self._frames.since(stamps[k]).apply(self._points(self._instances[k])) for k in fresh
        ]
        return Sight.still(np.vstack(each))

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
