"""The last look before a velocity is driven: slow down or stop for what the lidar sees now."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint

ZONES = ("PolygonStop", "PolygonSlow", "PolygonLimit", "FootprintApproach")


class Action(enum.IntEnum):
    """What is done to a velocity; the values are nav2_msgs/msg/CollisionMonitorState's."""

    DO_NOTHING = 0
    STOP = 1
    SLOWDOWN = 2
    APPROACH = 3
    LIMIT = 4


@dataclass(frozen=True)
class ZoneConfig:
    """One zone round the robot, by Nav2's names."""

    enabled: bool = param(True, "Whether the zone counts.")
    points: str = param("[]", "Corners [[x, y], ...]; empty for a circle.", unit="m")
    radius: float = param(0.5, "Radius of the circle.", unit="m", minimum=0.01)
    min_points: int = param(4, "Points within that make it count.", minimum=1)


@dataclass(frozen=True)
class SlowConfig(ZoneConfig):
    """A zone that slows down."""

    slowdown_ratio: float = param(0.5, "Part of the speed left.", minimum=0.0, maximum=1.0)


@dataclass(frozen=True)
class LimitConfig(ZoneConfig):
    """A zone that limits the speed."""

    linear_limit: float = param(0.5, "Greatest speed.", unit="m/s", minimum=0.0)
    angular_limit: float = param(0.5, "Greatest yaw rate.", unit="rad/s", minimum=0.0)


@dataclass(frozen=True)
class ApproachConfig:
    """The footprint's own zone: keeps a time before any collision."""

    enabled: bool = param(True, "Whether the zone counts.")
    min_points: int = param(6, "Points within that make it count.", minimum=1)
    time_before_collision: float = param(1.2, "Time kept.", unit="s", minimum=0.01)
    simulation_time_step: float = param(0.1, "Step of looking ahead.", unit="s", minimum=0.01)


@dataclass(frozen=True)
class MonitorConfig:
    """Parameters of the collision monitor.

    Raises:
        ConfigError: A zone's points are no corners.
    """

    polygons: tuple[str, ...] = param(
        ("FootprintApproach",), "The zones in use.", choices=ZONES, read_only=True
    )
    PolygonStop: ZoneConfig = field(default_factory=ZoneConfig)
    PolygonSlow: SlowConfig = field(default_factory=SlowConfig)
    PolygonLimit: LimitConfig = field(default_factory=LimitConfig)
    FootprintApproach: ApproachConfig = field(default_factory=ApproachConfig)

    def __post_init__(self) -> None:
        for zone in (self.PolygonStop, self.PolygonSlow, self.PolygonLimit):
            Footprint.parse(zone.points, zone.radius, 0.0)


@dataclass(frozen=True)
class Verdict:
    """What may be driven, and why it is not what was asked.

    Attributes:
        velocity: What may be driven.
        action: What was done.
        zone: Because of which zone; empty where nothing was done.
    """

    velocity: Velocity
    action: Action = Action.DO_NOTHING
    zone: str = ""


class CollisionMonitor:
    """Keeps the part of a velocity that every zone allows.

    Args:
        config: The zones.

    Source: nav2_collision_monitor, CollisionMonitor::process.
    """

    def __init__(self, config: MonitorConfig) -> None:
        self._config = config
        self._outlines = {
            name: Footprint.parse(getattr(config, name).points, getattr(config, name).radius, 0.0)
            for name in ZONES[:3]
        }

    def judge(
        self, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> Verdict:
        """Return what may be driven.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
        """
        verdict, least = Verdict(velocity), 1.0
        for name in self._config.polygons:
            if not getattr(self._config, name).enabled:
                continue
            ratio, action = self._allowed(name, velocity, points, footprint)
            if ratio < least:
                least = ratio
                verdict = Verdict(Velocity(velocity.v * ratio, velocity.w * ratio), action, name)
        return verdict

    def _allowed(
        self, name: str, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> tuple[float, Action]:
        """Return the part of a velocity that a zone allows."""
        config = self._config
        if name == "FootprintApproach":
            return self._until_collision(velocity, points, footprint), Action.APPROACH
        entered = _count(points, self._outlines[name]) >= getattr(config, name).min_points
        if name == "PolygonStop":
            return (0.0 if entered else 1.0), Action.STOP
        if name == "PolygonSlow":
            return (config.PolygonSlow.slowdown_ratio if entered else 1.0), Action.SLOWDOWN
        limit = config.PolygonLimit
        ratios = (
            _ratio(limit.linear_limit, velocity.v),
            _ratio(limit.angular_limit, velocity.w),
        )
        return (min(ratios) if entered else 1.0), Action.LIMIT

    def _until_collision(
        self, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> float:
        """Return how long nothing is met, as a part of the time to be kept.

        The time is that of the last free step, where Nav2 takes the first that collides: so the
        robot stands before an obstacle rather than creep into it.
        """
        zone = self._config.FootprintApproach
        duration, step = zone.time_before_collision, zone.simulation_time_step
        reach = footprint.circumscribed_radius + abs(velocity.v) * duration
        near = points[np.hypot(*points.T) <= reach]
        if len(near) < zone.min_points or velocity == Velocity():
            return 1.0
        twist = np.array([velocity.v, 0.0, velocity.w])
        for k in range(math.ceil(duration / step)):
            seen = SE2.exp(twist * (k * step)).inverse().apply(near)
            if _count(seen, footprint) >= zone.min_points:
                return max(k - 1, 0) * step / duration
        return 1.0


def _ratio(limit: float, value: float) -> float:
    return limit / abs(value) if abs(value) > limit else 1.0


def _count(points: NDArray[np.float64], outline: Footprint) -> int:
    """Return how many points lie within an outline."""
    if outline.circular:
        return int((np.hypot(*points.T) <= outline.circumscribed_radius).sum())
    return int(_inside(points, outline.points).sum())


def _inside(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell which points a ray from crosses the outline an odd number of times."""
    x, y = points[:, :1], points[:, 1:]
    x0, y0 = corners.T
    x1, y1 = np.roll(corners, -1, axis=0).T
    spans = (y0 <= y) != (y1 <= y)
    slope = np.divide(x1 - x0, y1 - y0, out=np.zeros_like(x0), where=y1 != y0)
    crossed = spans & (x < x0 + (y - y0) * slope)
    odd: NDArray[np.bool_] = crossed.sum(axis=1) % 2 == 1
    return odd
