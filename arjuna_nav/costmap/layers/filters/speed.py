"""The filter that limits the speed in zones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.layers.base import Master
from arjuna_nav.costmap.layers.filters.base import UNKNOWN_MASK, CostmapFilter, FilterConfig
from arjuna_nav.costmap.window import Window

_PERCENTAGE, _ABSOLUTE = 1, 2
_NONE = 0.0  # a limit that is none


@dataclass(frozen=True)
class SpeedConfig(FilterConfig):
    """Parameters of the speed filter."""

    speed_limit_topic: str = param("speed_limit", "Topic of the limits.", read_only=True)


@dataclass(frozen=True)
class SpeedLimit:
    """A limit of the speed.

    Attributes:
        percentage: Whether it is in per cent of the greatest speed; else in m/s.
        limit: The limit; 0 lifts it.
    """

    percentage: bool
    limit: float


class SpeedFilter(CostmapFilter):
    """Limits the speed by the mask's value where the robot is; 0 lifts the limit.

    Outside the mask, where it is unknown and where its frame is not known, the last limit holds.

    Source: nav2_costmap_2d, speed filter.
    """

    Config: ClassVar[type[Any]] = SpeedConfig
    TYPES = (_PERCENTAGE, _ABSOLUTE)

    def __init__(self, config: SpeedConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._limit = self._taken = SpeedLimit(False, _NONE)

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        """Look up the limit where the robot is."""
        value = self._value_at(T_global_base)
        if value is not None and value != UNKNOWN_MASK and self._info is not None:
            percentage = self._info.type == _PERCENTAGE
            limit = self._info.base + self._info.multiplier * value if value else _NONE
            valid = 0.0 <= limit <= (100.0 if percentage else float("inf"))
            self._limit = SpeedLimit(percentage, limit if valid else _NONE)
        return None

    def take_change(self) -> SpeedLimit | None:
        """Return the limit if it is another than at the last call."""
        changed = self._limit.limit != self._taken.limit
        self._taken = self._limit
        return self._limit if changed else None
