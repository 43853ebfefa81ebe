"""The filter that switches something on and off in zones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.layers.base import Master
from arjuna_nav.costmap.layers.filters.base import UNKNOWN_MASK, CostmapFilter, FilterConfig
from arjuna_nav.costmap.window import Window


@dataclass(frozen=True)
class BinaryConfig(FilterConfig):
    """Parameters of the binary filter."""

    default_state: bool = param(False, "State outside the zones.")
    binary_state_topic: str = param("binary_state", "Topic of the state.", read_only=True)
    flip_threshold: float = param(50.0, "Value from beyond which on the state is the other.")


class BinaryFilter(CostmapFilter):
    """Says whether the robot is where the mask's value is over a threshold.

    Source: nav2_costmap_2d, binary filter.
    """

    Config: ClassVar[type[Any]] = BinaryConfig
    TYPES = (3,)

    def __init__(self, config: BinaryConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._state = config.default_state
        self._taken: bool | None = None

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        """Look up the state where the robot is."""
        value = self._value_at(T_global_base)
        if self._mask is None or self._info is None or self._problem or value == UNKNOWN_MASK:
            return None
        info, threshold = self._info, self.config.flip_threshold
        over = value is not None and info.base + info.multiplier * value > threshold
        self._state = self.config.default_state != over
        return None

    def take_change(self) -> bool | None:
        """Return the state if it is another than at the last call, or the first."""
        changed = self._state != self._taken
        self._taken = self._state
        return self._state if changed else None
