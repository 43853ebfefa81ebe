"""Layers by masks: zones to keep out of, to drive slowly in, and to switch something in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Bytes
from arjuna_core.config import fixed, param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, MAX_NON_OBSTACLE, UNKNOWN
from arjuna_nav.costmap.layers.base import Input, Master, absolute, combine
from arjuna_nav.costmap.layers.static import MapLayer, PlacedMap, Placement
from arjuna_nav.costmap.window import Window, whole

UNKNOWN_MASK = -1


@dataclass(frozen=True)
class FilterConfig:
    """Parameters of every filter."""

    enabled: bool = param(True, "Whether the filter takes part.")
    filter_info_topic: str = fixed("", "Topic of the message that says where its mask is.")
    transform_tolerance: float = param(
        0.1, "Unused: the latest transform is taken, and nothing waits for it.", unit="s"
    )


@dataclass(frozen=True)
class FilterInfo:
    """Meaning of a mask's values: `base + multiplier * value`.

    Attributes:
        type: Of the filter: 0 keeps out, 1 limits the speed in per cent, 2 in m/s, 3 switches.
        multiplier: Of a value of the mask.
    """

    type: int
    mask_topic: str
    base: float = 0.0
    multiplier: float = 1.0


class CostmapFilter(MapLayer):
    """A layer that has a mask.

    Attributes:
        TYPES: Of info messages that it understands.

    Source: nav2_costmap_2d, costmap filters.
    """

    TYPES: ClassVar[tuple[int, ...]] = ()

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._info: FilterInfo | None = None
        self._wrong_type: int | None = None

    def inputs(self) -> tuple[Input, ...]:
        topic = self.config.filter_info_topic
        info = (Input("info", topic, "CostmapFilterInfo", latched=True),) if topic else ()
        if self._info is None:
            return info
        mask = self._info.mask_topic
        return (*info, Input(mask, mask, "OccupancyGrid", latched=True))

    def receive(self, source: str, value: FilterInfo | PlacedMap) -> None:
        if isinstance(value, PlacedMap):
            if self._info is not None and source == self._info.mask_topic:
                self._map = value
                self._drop()
        elif value.type not in self.TYPES:
            self._wrong_type = value.type
        elif value != self._info:
            self._info, self._map, self._wrong_type = value, None, None
            self._drop()

    def warning(self) -> str:
        topic = self.config.filter_info_topic
        if not topic:
            return "filter_info_topic is empty: the filter has no mask"
        if self._wrong_type is not None:
            valid = " or ".join(map(str, self.TYPES))
            return f"{absolute(topic)} says type {self._wrong_type}; this filter takes {valid}"
        if self._info is None:
            return f"no CostmapFilterInfo has come on {absolute(topic)}"
        return "" if self._map else f"no mask has come on {absolute(self._info.mask_topic)}"

    def _value_at(self, T_global_base: SE2) -> int | None:
        """Return the mask's value where the robot is, -1 for unknown; None outside it."""
        if self._map is None or (T_global_mask := self._locate()) is None:
            return None
        at = T_global_mask.inverse() @ T_global_base
        grid = self._map.grid
        row, column = grid.frame.to_cell(at.x, at.y)
        return int(np.int8(grid.data[row, column])) if grid.frame.contains(row, column) else None


@dataclass(frozen=True)
class KeepoutConfig(FilterConfig):
    """Parameters of the keepout filter."""

    override_lethal_cost: bool = param(
        False, "Whether a robot that stands in a zone may drive out of it."
    )
    lethal_override_cost: int = param(
        MAX_NON_OBSTACLE, "What a zone costs then.", minimum=0, maximum=LETHAL
    )
    worst_of_cell: bool = param(
        True,
        "Whether a zone counts in each cell that it reaches into; else, as Nav2, in those whose"
        " middle it holds.",
        theirs=False,
    )


class KeepoutFilter(CostmapFilter):
    """Raises costs to those of a mask: 100 is lethal, what is less costs as much of it.

    Source: nav2_costmap_2d, keepout filter.
    """

    Config: ClassVar[type[Any]] = KeepoutConfig
    TYPES = (0,)

    def __init__(self, config: KeepoutConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._made_of: tuple[PlacedMap, bool] | None = None  # the mask, and if overridden

    def reconfigure(self, config: Any) -> None:
        super().reconfigure(config)
        self._made_of = None

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        before = self._placement
        T_global_mask = self._locate() if self._map is not None else None
        if self._map is not None and T_global_mask is not None:
            self._weigh(self._map, T_global_base)
        self._place(T_global_mask)
        same, self._dropped = self._placement is before and not self._dropped, False
        return None if same else whole(self.master.frame.shape)

    def write(self, costs: Bytes, window: Window) -> None:
        if self._placement is not None:
            self._place(self._placement.T_global_map)
            combine(costs, self._shown[window], 1)

    def _weigh(self, mask: PlacedMap, T_global_base: SE2) -> None:
        """Take the costs of the mask's cells, where the mask is new or the robot stands in it."""
        value = self._value_at(T_global_base) if self.config.override_lethal_cost else None
        overridden = value is not None and bool(_is_zone(_costs_of(np.array([value])))[0])
        if self._made_of is None or self._made_of[0] is not mask or self._made_of[1] != overridden:
            costs = _costs_of(mask.grid.data)
            if overridden:
                costs[_is_zone(costs)] = self.config.lethal_override_cost
            self._costs, self._made_of, self._placement = costs, (mask, overridden), None

    def _read(self, placement: Placement) -> Bytes:
        """Return the mask's worst cost in each of the costmap's cells, or that in their middles.

        In their middles a robot may enter a zone by half a cell.
        """
        worst = self.config.worst_of_cell
        return placement.read_worst(self._costs) if worst else super()._read(placement)


def _is_zone(costs: Bytes) -> Bools:
    zone: Bools = (costs == INSCRIBED) | (costs == LETHAL)
    return zone


def _costs_of(data: NDArray[Any]) -> Bytes:
    """Return the costs of a mask's values, `uint8`."""
    costs = np.round(data.astype(np.float64) * LETHAL / 100.0)
    return np.where(data == UNKNOWN_MASK, UNKNOWN, costs).astype(np.uint8)


@dataclass(frozen=True)
class SpeedConfig(FilterConfig):
    """Parameters of the speed filter."""

    speed_limit_topic: str = fixed("speed_limit", "Topic of the limits.")


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
    TYPES = (1, 2)

    def __init__(self, config: SpeedConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._limit = self._taken = SpeedLimit(False, 0.0)

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        value = self._value_at(T_global_base)
        if value is not None and value != UNKNOWN_MASK and self._info is not None:
            percentage = self._info.type == 1
            limit = self._info.base + self._info.multiplier * value if value else 0.0
            valid = 0.0 <= limit <= (100.0 if percentage else float("inf"))
            self._limit = SpeedLimit(percentage, limit if valid else 0.0)
        return None

    def take_change(self) -> SpeedLimit | None:
        """Return the limit if it is another than at the last call."""
        changed = self._limit.limit != self._taken.limit
        self._taken = self._limit
        return self._limit if changed else None


@dataclass(frozen=True)
class BinaryConfig(FilterConfig):
    """Parameters of the binary filter."""

    default_state: bool = param(False, "State outside the zones.")
    binary_state_topic: str = fixed("binary_state", "Topic of the state.")
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
        value = self._value_at(T_global_base)
        if self._map is None or self._info is None or self._problem or value == UNKNOWN_MASK:
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
