"""The sources and the zones' shapes of a collision monitor or detector."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PolygonStamped
from std_msgs.msg import Float32
from visualization_msgs.msg import MarkerArray

from arjuna_core.config import duration_param, fixed, param, plugin_names
from arjuna_core.errors import ConfigError, nearest
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.silence import Silence, why_silent
from arjuna_core.ros.tf import TransformError
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.costmap.messages import points_from_polygon, points_marker, polygon_msg
from arjuna_nav.nodes.costmap.reader import costmap_in_process
from arjuna_nav.nodes.costmap.sensors import WatchFrames
from arjuna_nav.nodes.safety.sources import SOURCES, ScanSource, Source
from arjuna_nav.safety.collision_monitor import CollisionMonitor, MonitorConfig
from arjuna_nav.safety.sight import Sight, Touching
from arjuna_nav.safety.zones import CircleConfig, PolygonConfig


@dataclass(frozen=True)
class WatchConfig(MonitorConfig):
    """Parameters that `collision_monitor` and `collision_detector` share, by Nav2's names.

    Raises:
        ConfigError: A zone has no shape, or names a source that does not exist.
    """

    observation_sources: tuple[str, ...] = plugin_names((), "What sees.", SOURCES)
    base_frame_id: str = fixed("", "Frame of the robot; empty: the local costmap's.")
    odom_frame_id: str = fixed(
        "", "Frame in which what is seen stays put; empty: the local costmap's."
    )
    transform_tolerance: float = duration_param(
        0.1, "By how much transforms may be older than what is seen."
    )
    source_timeout: float = duration_param(2.0, "How old what a source says may be; 0: any age.")
    base_shift_correction: bool = fixed(
        True, "Whether what was seen is moved to where the robot is now."
    )
    brake_before_source_timeout: bool = param(
        False,
        "Whether the robot slows down where nothing has come for three fifths of the time-out, "
        "which then is never less than 2.5 of a source's periods; Nav2 stops at once.",
        theirs=False,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.polygons:
            named = getattr(getattr(self, name, None), "sources_names", ())
            missing = [each for each in named if each not in self.observation_sources]
            if missing:
                hint = nearest(missing[0], self.observation_sources)
                raise ConfigError(f"'{name}.sources_names': no source '{missing[0]}'; {hint}")


class Watch:
    """The sources, by name, and zones of a node in its `configure`."""

    def __init__(self, node: ManagedNode) -> None:
        self._node, self._near = node, costmap_in_process(node, "local_costmap/costmap_raw")
        near = self._near
        config: WatchConfig = node.config
        self.base = config.base_frame_id or (near.config.robot_base_frame if near else "base_link")
        odom = config.odom_frame_id or (near.config.global_frame if near else "odom")
        frames = WatchFrames(
            node, odom, self.base, config.base_shift_correction, config.transform_tolerance
        )
        self.sources: dict[str, Source] = {}
        for name in config.observation_sources:
            own = getattr(config, name)
            topic = own.topic or (near.scan_topic if near else "scan")
            timeout, brakes = config.source_timeout, config.brake_before_source_timeout
            if topic:
                self.sources[name] = SOURCES.make(own, frames, topic, timeout, brakes)
        self._seen, self._touching = Sight.joined([]), Touching()
        markers = f"{node.get_name()}/collision_points_marker"
        self._points = node.publisher(MarkerArray, markers, qos.DEFAULT)
        self._messages: dict[str, Any] = {}
        self._outputs: dict[str, Any] = {}
        for name in config.polygons:
            self._listen(name, getattr(config, name))
        self.reconfigure(config)

    def _listen(self, name: str, zone: Any) -> None:
        """Subscribe to a zone's shape where a topic says it, and publish it where asked for."""
        node, take = self._node, partial(self._messages.__setitem__, name)
        if zone.visualize:
            topic = zone.polygon_pub_topic or name
            self._outputs[name] = node.publisher(PolygonStamped, topic, qos.DEFAULT)
        if not isinstance(zone, (PolygonConfig, CircleConfig)) or zone.fixed() is not None:
            return
        kind, topic = PolygonStamped, zone.polygon_sub_topic
        if isinstance(zone, CircleConfig):
            kind = Float32
        elif zone.action_type == "approach":
            elsewhere = "" if self._near else "local_costmap/published_footprint"
            topic = zone.footprint_topic or elsewhere
        latched = zone.polygon_subscribe_transient_local
        if topic:
            node.subscribe(kind, topic, take, qos.LATCHED if latched else qos.DEFAULT)

    def reconfigure(self, config: WatchConfig) -> None:
        """Use new parameters from now on."""
        self.monitor = CollisionMonitor(config, tuple(self.sources))
        approach = (getattr(config, name) for name in config.polygons)
        tracks = any(z.action_type == "approach" and z.moving_time > 0.0 for z in approach)
        for name, source in self.sources.items():
            source.config = getattr(config, name)
            source.tracks = tracks and isinstance(source, ScanSource)

    def reset(self) -> None:
        """Forget what was seen."""
        self._touching = Touching()
        for source in self.sources.values():
            source.reset()

    def footprint(self) -> Footprint:
        """Return the robot's own outline, without padding."""
        if self._near is None:
            return Footprint.circle(1e-3)  # as with Nav2, a zone is empty until its shape comes
        return self._near.layered.body

    def silent(self) -> str:
        """Return which source says nothing and since when; empty where all speak."""
        return next(filter(None, (source.problem() for source in self.sources.values())), "")

    def why_silent(self) -> str:
        """Return the reason of `silent`, with what can be done."""
        for name, source in self.sources.items():
            if problem := source.problem():
                advice = f"set {name}.topic"
                of = Silence(
                    source.message_type, source.config.type, qos.SENSOR_SUBSCRIPTION, advice
                )
                return f"{problem}: {why_silent(self._node, source.topic, of)}"
        return ""

    def look(self, wait_for_all: bool = True) -> tuple[Sight, float] | None:
        """Return what is seen now, and which share of its speed the robot may keep.

        Args:
            wait_for_all: Whether to return None where a source that counts is silent or useless;
                else it is left out.
        """
        self._update_shapes()
        sights, trust, blind = [], 1.0, False
        for number, source in enumerate(self.sources.values()):
            if not source.config.enabled:
                continue
            share = source.trust()
            sight = self._sight(source) if share > 0.0 else None
            if sight is not None:
                trust = min(trust, share)
                sights.append(sight._replace(sources=np.full(len(sight.points), number)))
            else:
                blind = blind or source.timeout != 0.0
        seen = Sight.joined(sights)
        self._seen = self._touching.keep(seen, self.footprint(), self._node.now)
        return None if blind and wait_for_all else (self._seen, trust)

    def _sight(self, source: Source) -> Sight | None:
        try:
            return source.sight()
        except (TransformError, ValueError) as error:
            self._node.get_logger().warning(f"blind: {error}", throttle_duration_sec=1.0)
            return None

    def _update_shapes(self) -> None:
        for name, message in self._messages.items():
            zone = self.monitor.zones.get(name)
            if zone is None:
                continue
            try:
                zone.shape = self._shape(message)
            except (ConfigError, TransformError) as error:
                problem = f"the shape of zone '{name}' is not used: {error}"
                self._node.get_logger().warning(problem, throttle_duration_sec=1.0)

    def _shape(self, message: Any) -> Footprint:
        if not hasattr(message, "polygon"):
            return Footprint.circle(float(message.data))
        points, transforms = points_from_polygon(message.polygon), self._node.transforms
        frame = message.header.frame_id.lstrip("/") or self.base
        if frame != self.base:
            stamp = min(seconds(message.header.stamp), transforms.latest_common(self.base, frame))
            points = transforms.lookup(self.base, frame, stamp or None).apply(points)
        return Footprint.polygon(points)

    def publish(self, velocity: Velocity) -> None:
        """Publish the shapes that are to be shown, and what was seen last if someone listens."""
        for name, output in self._outputs.items():
            zone = self.monitor.zones.get(name)
            outline = zone.outline(velocity, self.footprint()) if zone is not None else None
            if outline is not None:
                output.publish(polygon_msg(outline.points, self.base, self._node.now))
        if self._points.get_subscription_count() > 0:
            points, numbers = self._seen.points, self._seen.sources
            several = [
                points_marker(points[numbers == number], self.base, name)
                for number, name in enumerate(self.sources)
            ]
            self._points.publish(MarkerArray(markers=several))
