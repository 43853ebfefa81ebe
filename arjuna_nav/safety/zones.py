"""Zones round the robot: what part of a velocity each allows."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from arjuna_core.config import (
    fixed,
    length_param,
    param,
    plugin_names,
    share_param,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import NamedConfigs, PluginTypes
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.approach import Approach, ApproachConfig, inside
from arjuna_nav.safety.sight import Sight


class Action(enum.IntEnum):
    """Effect of a zone on a velocity; the values are nav2_msgs/msg/CollisionMonitorState's."""

    DO_NOTHING = 0
    STOP = 1
    SLOWDOWN = 2
    APPROACH = 3
    LIMIT = 4


ACTIONS = {
    "stop": Action.STOP,
    "slowdown": Action.SLOWDOWN,
    "limit": Action.LIMIT,
    "approach": Action.APPROACH,
    "none": Action.DO_NOTHING,
}
"""By Nav2's `action_type`."""


@dataclass(frozen=True)
class ZoneConfig(ApproachConfig):
    """One zone round the robot, by Nav2's names."""

    enabled: bool = param(True, "Whether the zone counts.")
    action_type: str = param("stop", "What it does.", choices=tuple(ACTIONS))
    min_points: int = param(4, "Points within that make it count.", minimum=1)
    max_points: int = param(
        -1, "Points within that do not yet make it count; below 0: by min_points.", minimum=-1
    )
    slowdown_ratio: float = share_param(0.5, "Part of the speed left.")
    linear_limit: float = speed_param(0.5, "Greatest speed.")
    angular_limit: float = yaw_rate_param(0.5, "Greatest yaw rate.")
    sources_names: tuple[str, ...] = param(
        (), "The sources that count; none: all of observation_sources."
    )
    visualize: bool = fixed(False, "Whether to publish its outline.")
    polygon_pub_topic: str = fixed("", "Topic of its outline; empty: its name.")
    polygon_sub_topic: str = fixed(
        "", "Topic that its shape comes from, where no parameter says it."
    )
    polygon_subscribe_transient_local: bool = fixed(False, "Whether that topic is latched.")

    @property
    def least(self) -> int:
        """Least number of points within that makes the zone count."""
        return self.min_points if self.max_points < 0 else self.max_points + 1

    def problem(self) -> str:
        """Return what its values lack; empty where nothing."""
        return ""


@dataclass(frozen=True)
class PolygonConfig(ZoneConfig):
    """A polygon, or the robot's outline."""

    points: str = param("", "Corners '[[x, y], [x, y], [x, y], ...]'.", unit="m")
    footprint_topic: str = fixed(
        "local_costmap/published_footprint",
        "Where a zone that approaches and has no points gets the robot's outline; empty: from the "
        "local costmap, its body or its footprint without padding.",
    )

    def problem(self) -> str:
        """Return what its values lack; empty where nothing."""
        try:
            known = self.fixed() is not None
        except ConfigError as error:
            return str(error)
        if known or self.polygon_sub_topic or self.action_type == "approach":
            return ""
        return "a zone of type polygon needs points [[x, y], ...] or polygon_sub_topic"

    def fixed(self) -> Footprint | None:
        """Return its shape, None where the parameters name none."""
        empty = self.points.strip() in ("", "[]")
        return None if empty else Footprint.parse(self.points, 0.0, 0.0)


@dataclass(frozen=True)
class CircleConfig(ZoneConfig):
    """A circle."""

    radius: float = length_param(0.0, "Its radius; 0: polygon_sub_topic, a Float32, says it.")

    def problem(self) -> str:
        """Return what its values lack; empty where nothing."""
        known = self.radius > 0.0 or self.polygon_sub_topic
        return "" if known else "a zone of type circle needs a radius or polygon_sub_topic"

    def fixed(self) -> Footprint | None:
        """Return its shape, None where the parameters name none."""
        return Footprint.circle(self.radius) if self.radius > 0.0 else None


class Zone:
    """A zone of one shape: a polygon, or the robot's outline.

    Args:
        config: Its parameters, of `ZoneConfig`.

    Attributes:
        shape: Its outline as a message brought it; None where none has come.

    Source: nav2_collision_monitor, Polygon and CollisionMonitor::processStopSlowdownLimit.
    """

    Config: ClassVar[type[Any]] = PolygonConfig

    def __init__(self, config: Any) -> None:
        self._config = config
        self.action = ACTIONS[config.action_type]
        self.shape: Footprint | None = None
        self._approach = Approach(config, config.least)

    @cached_property
    def _fixed(self) -> Footprint | None:
        fixed: Footprint | None = self._config.fixed()
        return fixed

    def outline(self, velocity: Velocity, footprint: Footprint) -> Footprint | None:
        """Return its outline in the base frame at a velocity; None while it has none."""
        if self._fixed is not None or self.shape is not None:
            return self._fixed or self.shape
        own = self.action is Action.APPROACH and not getattr(self._config, "footprint_topic", "")
        return footprint if own else None

    def counts(self, velocity: Velocity, sight: Sight, footprint: Footprint) -> bool:
        """Return whether it holds as many points as count."""
        outline = self.outline(velocity, footprint)
        return inside(outline, sight.points) >= int(self._config.least)

    def allowed(self, velocity: Velocity, sight: Sight, footprint: Footprint) -> float:
        """Return the part of a velocity that it allows, 0 to 1."""
        outline = self.outline(velocity, footprint)
        if outline is None or self.action is Action.DO_NOTHING:
            return 1.0
        if self.action is Action.APPROACH:
            return self._approach.allowed(velocity, sight, outline)
        if inside(outline, sight.points) < self._config.least:
            return 1.0
        return self._limited_part(velocity)

    def _limited_part(self, velocity: Velocity) -> float:
        if self.action is Action.STOP:
            return 0.0
        if self.action is Action.SLOWDOWN:
            return float(self._config.slowdown_ratio)
        limits = (
            (self._config.linear_limit, velocity.speed),
            (self._config.angular_limit, abs(velocity.yaw_rate)),
        )
        return min(limit / value if value > limit else 1.0 for limit, value in limits)


class CircleZone(Zone):
    """A circle round the robot."""

    Config: ClassVar[type[Any]] = CircleConfig


@dataclass(frozen=True)
class VelocityPartConfig:
    """The shape of a velocity polygon at some velocities."""

    points: str = param("", "Corners '[[x, y], [x, y], [x, y], ...]'.", unit="m")
    linear_min: float = param(
        0.0, "Least forward speed; of a holonomic robot the speed in any direction.", unit="m/s"
    )
    linear_max: float = param(0.0, "Greatest of it.", unit="m/s")
    theta_min: float = param(0.0, "Least yaw rate.", unit="rad/s")
    theta_max: float = param(0.0, "Greatest yaw rate.", unit="rad/s")
    direction_start_angle: float = param(
        -math.pi, "Of a holonomic robot, where its directions begin.", unit="rad"
    )
    direction_end_angle: float = param(math.pi, "Where they end, to the left.", unit="rad")

    def holds(self, velocity: Velocity, holonomic: bool) -> bool:
        """Return whether a velocity is one of its.

        Source: nav2_collision_monitor, VelocityPolygon::isInRange.
        """
        speed = velocity.speed if holonomic else velocity.x
        fits = self.linear_min <= speed <= self.linear_max
        fits = fits and self.theta_min <= velocity.yaw_rate <= self.theta_max
        if not (fits and holonomic):
            return fits
        start, end = self.direction_start_angle, self.direction_end_angle
        course = math.atan2(velocity.y, velocity.x)
        return start <= course <= end if start <= end else course >= start or course <= end


@dataclass(frozen=True)
class VelocityPolygonConfig(ZoneConfig):
    """A zone whose shape is chosen by the velocity."""

    velocity_polygons: tuple[str, ...] = plugin_names(
        (),
        "Its shapes; the first that holds the velocity counts.",
        NamedConfigs(VelocityPartConfig),
    )
    holonomic: bool = param(False, "Whether the direction of the motion counts too.")

    def problem(self) -> str:
        """Return what its values lack; empty where nothing."""
        if not self.velocity_polygons:
            return "a zone of type velocity_polygon needs velocity_polygons, a list of names"
        for name in self.velocity_polygons:
            try:
                Footprint.parse(getattr(self, name).points or "[[0]]", 0.0, 0.0)
            except ConfigError as error:
                return f"'{name}.points': {error}"
        return ""


class VelocityPolygonZone(Zone):
    """A zone whose shape is chosen by the velocity; the last one stays where none holds it.

    Source: nav2_collision_monitor, VelocityPolygon::updatePolygon.
    """

    Config: ClassVar[type[Any]] = VelocityPolygonConfig

    def __init__(self, config: Any) -> None:
        super().__init__(config)
        shapes = {name: getattr(config, name) for name in config.velocity_polygons}
        self._shapes = [(s, Footprint.parse(s.points, 0.0, 0.0)) for s in shapes.values()]

    def outline(self, velocity: Velocity, footprint: Footprint) -> Footprint | None:
        """Return its outline in the base frame at a velocity; None while it has none."""
        holonomic = self._config.holonomic
        found = (each for part, each in self._shapes if part.holds(velocity, holonomic))
        self.shape = next(found, self.shape)
        return self.shape


ZONES = PluginTypes(
    "zone",
    {
        "polygon": f"{__name__}:Zone",
        "circle": f"{__name__}:CircleZone",
        "velocity_polygon": f"{__name__}:VelocityPolygonZone",
    },
    "polygon",
    key="type",
)
"""Zones by their shape, Nav2's `type`."""
