"""Zones round the robot: what part of a velocity each allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.base import Action


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
        speeds: NDArray[np.float64] | None = None,
    ) -> float:
        """Return the part of a velocity that is allowed."""
        entered = self._outline.holds(points).sum() >= self._config.min_points
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


ZONES = PluginTypes(
    "zone",
    {
        "stop": f"{__name__}:StopZone",
        "slowdown": f"{__name__}:SlowZone",
        "limit": f"{__name__}:LimitZone",
        "approach": "arjuna_nav.safety.approach:ApproachZone",
    },
    "stop",
    {"PolygonSlow": "slowdown", "PolygonLimit": "limit", "FootprintApproach": "approach"},
    "action_type",
)
"""Zones by what they do, Nav2's `action_type`; Nav2's usual names need not say it."""


def _ratio(limit: float, value: float) -> float:
    return limit / abs(value) if abs(value) > limit else 1.0
