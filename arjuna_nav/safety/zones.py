"""Zones round the robot: what part of a velocity each allows."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint

_SCALES = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Of the outline, until what touches the robot lies outside."""
_PARTS = (1.0, 0.7, 0.4, 0.2, 0.0)
"""Of a velocity, tried one after the other before what moves."""
_ROOM = 0.1  # kept to what moves, all round [m]
_ESCAPES = 0.3  # later that it is met if the robot drives on, which is then better [s]


class Action(enum.IntEnum):
    """What is done to a velocity; the values are nav2_msgs/msg/CollisionMonitorState's."""

    DO_NOTHING = 0
    STOP = 1
    SLOWDOWN = 2
    APPROACH = 3
    LIMIT = 4


class Zone(Protocol):
    """A zone, made of its `Config`.

    Attributes:
        action: What it does.
    """

    action: ClassVar[Action]

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
    ) -> float:
        """Return the part of a velocity that it allows, 0 to 1.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2) float64` in the base frame [m].
            footprint: The robot.
            motions: Their velocities over ground, `(N, 2)` in the base frame [m/s].
        """
        ...


@dataclass(frozen=True)
class ZoneConfig:
    """One zone round the robot, by Nav2's names.

    Raises:
        ConfigError: Its points are no corners, or a polygon has none.
    """

    enabled: bool = param(True, "Whether the zone counts.")
    type: str = param(
        "", "Its form; empty for what points or radius say.", choices=("", "polygon", "circle")
    )
    points: str = param("[]", "Corners [[x, y], ...]; empty for a circle.", unit="m")
    radius: float = param(0.5, "Radius of the circle.", unit="m", minimum=0.01)
    min_points: int = param(4, "Points within that make it count.", minimum=1)

    def __post_init__(self) -> None:
        if self.outline().circular and self.type == "polygon":
            raise ConfigError("a zone of type polygon needs points [[x, y], ...]")

    def outline(self) -> Footprint:
        """Return the zone's outline in the base frame."""
        points = "[]" if self.type == "circle" else self.points
        return Footprint.parse(points, self.radius, 0.0)


class _Entered:
    """A zone that counts once enough points lie within it."""

    def __init__(self, config: Any) -> None:
        self._config = config
        self._outline = config.outline()

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
    ) -> float:
        """Return the part of a velocity that is allowed."""
        entered = _count(points, self._outline) >= self._config.min_points
        return self._left(velocity) if entered else 1.0

    def _left(self, velocity: Velocity) -> float:
        """Return the part that is left once it counts."""
        raise NotImplementedError


class StopZone(_Entered):
    """Stops the robot."""

    Config: ClassVar[type[Any]] = ZoneConfig
    action = Action.STOP

    def _left(self, velocity: Velocity) -> float:
        return 0.0


@dataclass(frozen=True)
class SlowConfig(ZoneConfig):
    """A zone that slows down."""

    slowdown_ratio: float = param(0.5, "Part of the speed left.", minimum=0.0, maximum=1.0)


class SlowZone(_Entered):
    """Slows the robot down by a part."""

    Config: ClassVar[type[Any]] = SlowConfig
    action = Action.SLOWDOWN

    def _left(self, velocity: Velocity) -> float:
        return float(self._config.slowdown_ratio)


@dataclass(frozen=True)
class LimitConfig(ZoneConfig):
    """A zone that limits the speed."""

    linear_limit: float = param(0.5, "Greatest speed.", unit="m/s", minimum=0.0)
    angular_limit: float = param(0.5, "Greatest yaw rate.", unit="rad/s", minimum=0.0)


class LimitZone(_Entered):
    """Slows the robot down to its limits."""

    Config: ClassVar[type[Any]] = LimitConfig
    action = Action.LIMIT

    def _left(self, velocity: Velocity) -> float:
        return min(
            _ratio(self._config.linear_limit, velocity.v),
            _ratio(self._config.angular_limit, velocity.w),
        )


@dataclass(frozen=True)
class ApproachConfig:
    """The footprint's own zone: keeps a time before any collision."""

    enabled: bool = param(True, "Whether the zone counts.")
    min_points: int = param(6, "Points within that make it count.", minimum=1)
    time_before_collision: float = param(0.5, "Time kept.", unit="s", minimum=0.01)
    simulation_time_step: float = param(0.1, "Step of looking ahead.", unit="s", minimum=0.01)
    moving_time: float = param(
        1.5,
        "How far ahead the ways of what moves are looked at; 0 takes all for standing.",
        unit="s",
        minimum=0.0,
    )


class ApproachZone:
    """Slows the robot down so that a collision stays a time away."""

    Config: ClassVar[type[Any]] = ApproachConfig
    action = Action.APPROACH

    def __init__(self, config: ApproachConfig) -> None:
        self._config = config

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
    ) -> float:
        """Return how long nothing is met, as a part of the time to be kept.

        The time is that of the last free step, where Nav2 takes the first that collides: so the
        robot stands before an obstacle rather than creep into it. It may always move away.
        """
        zone = self._config
        if velocity == Velocity():
            return 1.0
        allowed = self._before_what_stands(velocity, points, footprint)
        if motions is not None and zone.moving_time > 0.0:
            moves = motions.any(axis=1)
            ahead = self._before_what_moves(velocity, points[moves], motions[moves], footprint)
            allowed = min(allowed, ahead)
        return allowed

    def _before_what_stands(
        self, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> float:
        zone = self._config
        duration, step = zone.time_before_collision, zone.simulation_time_step
        reach = footprint.circumscribed_radius + abs(velocity.v) * duration
        near = points[np.hypot(*points.T) <= reach]
        if len(near) < zone.min_points:
            return 1.0
        near, outline = self._free(near, footprint)
        twist = np.array([velocity.v, 0.0, velocity.w])
        for k in range(1, math.ceil(duration / step)):
            seen = SE2.exp(twist * (k * step)).inverse().apply(near)
            if _count(seen, outline) >= zone.min_points:
                return (k - 1) * step / duration
        return 1.0

    def _before_what_moves(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        footprint: Footprint,
    ) -> float:
        """Return the greatest part of a velocity that keeps clear of what moves on as it does.

        Where all of them meet it the robot stands, unless it gets away by driving on.
        """
        speeds = np.hypot(*motions.T) + abs(velocity.v)
        reach = footprint.circumscribed_radius + self._config.moving_time * speeds
        near = np.hypot(*points.T) <= reach + _ROOM
        points, motions = points[near], motions[near]
        grown = footprint.scaled(1.0 + _ROOM / footprint.inscribed_radius)
        outline = grown if not _count(points, grown) else footprint
        if not len(points) or _count(points, outline):
            return 1.0
        free = [self._meeting(velocity, part, points, motions, outline) for part in _PARTS]
        for part, time in zip(_PARTS, free, strict=True):
            if time == math.inf:
                return part
        return 1.0 if free[0] > free[-1] + _ESCAPES else 0.0

    def _meeting(
        self,
        velocity: Velocity,
        part: float,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        outline: Footprint,
    ) -> float:
        """Return when a part of a velocity meets points that move, inf for never [s]."""
        step = self._config.simulation_time_step
        twist = np.array([velocity.v, 0.0, velocity.w]) * part
        for k in range(1, math.ceil(self._config.moving_time / step) + 1):
            time = k * step
            seen = SE2.exp(twist * time).inverse().apply(points + motions * time)
            if _count(seen, outline):
                return time
        return math.inf

    def _free(
        self, points: NDArray[np.float64], footprint: Footprint
    ) -> tuple[NDArray[np.float64], Footprint]:
        """Return the points that a motion may meet, and the robot's outline, free of them now.

        What is within the outline is the robot's own part, or touches it: that must not hold it for
        ever. So the outline is taken smaller, or where that does not help, the points away.
        """
        for scale in _SCALES:
            outline = footprint.scaled(scale)
            if _count(points, outline) < self._config.min_points:
                return points, outline
        return points[~_within(points, footprint)], footprint


ZONES = PluginTypes(
    "zone",
    {
        "stop": f"{__name__}:StopZone",
        "slowdown": f"{__name__}:SlowZone",
        "limit": f"{__name__}:LimitZone",
        "approach": f"{__name__}:ApproachZone",
    },
    "stop",
    {"PolygonSlow": "slowdown", "PolygonLimit": "limit", "FootprintApproach": "approach"},
    "action_type",
)
"""Zones by what they do, Nav2's `action_type`; Nav2's usual names need not say it."""


def _ratio(limit: float, value: float) -> float:
    return limit / abs(value) if abs(value) > limit else 1.0


def _count(points: NDArray[np.float64], outline: Footprint) -> int:
    """Return how many points lie within an outline."""
    return int(_within(points, outline).sum())


def _within(points: NDArray[np.float64], outline: Footprint) -> NDArray[np.bool_]:
    """Tell which points lie within an outline."""
    if outline.circular:
        near: NDArray[np.bool_] = np.hypot(*points.T) <= outline.circumscribed_radius
        return near
    return _inside(points, outline.points)


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
