"""What filters have in common: a mask, whose topic and meaning an info message says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformError
from arjuna_nav.costmap.layers.base import Input, Layer, Master, absolute
from arjuna_nav.costmap.layers.placement import PlacedMap

UNKNOWN_MASK = -1


@dataclass(frozen=True)
class FilterConfig:
    """Parameters of every filter."""

    enabled: bool = param(True, "Whether the filter takes part.")
    filter_info_topic: str = param(
        "", "Topic of the message that says where its mask is.", read_only=True
    )
    transform_tolerance: float = param(
        0.1, "Unused: the latest transform is taken, and nothing waits for it.", unit="s"
    )


@dataclass(frozen=True)
class FilterInfo:
    """What a mask means: `base + multiplier * value`.

    Attributes:
        type: Of the filter: 0 keeps out, 1 limits the speed in per cent, 2 in m/s, 3 switches.
        mask_topic: Where the mask is.
        base: What is added.
        multiplier: Of a value of the mask.
    """

    type: int
    mask_topic: str
    base: float = 0.0
    multiplier: float = 1.0


class CostmapFilter(Layer):
    """A layer that has a mask.

    Attributes:
        TYPES: Of info messages that it understands.

    Source: nav2_costmap_2d, costmap filters.
    """

    TYPES: ClassVar[tuple[int, ...]] = ()

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._info: FilterInfo | None = None
        self._mask: PlacedMap | None = None
        self._wrong_type: int | None = None
        self._problem = ""

    def inputs(self) -> tuple[Input, ...]:
        """Return the info and, once that has come, the mask by its topic."""
        topic = self.config.filter_info_topic
        info = (Input("info", topic, "CostmapFilterInfo", latched=True),) if topic else ()
        if self._info is None:
            return info
        mask = self._info.mask_topic
        return (*info, Input(mask, mask, "OccupancyGrid", latched=True))

    def receive(self, source: str, value: FilterInfo | PlacedMap) -> None:
        """Take an info, or the mask that the last one names."""
        if isinstance(value, PlacedMap):
            if self._info is not None and source == self._info.mask_topic:
                self._mask = value
        elif value.type not in self.TYPES:
            self._wrong_type = value.type
        elif value != self._info:
            self._info, self._mask, self._wrong_type = value, None, None

    def warning(self) -> str:
        """Return why it has no effect; empty where it has."""
        topic = self.config.filter_info_topic
        if not topic:
            return "filter_info_topic is empty: the filter has no mask"
        if self._wrong_type is not None:
            valid = " or ".join(map(str, self.TYPES))
            return f"{absolute(topic)} says type {self._wrong_type}; this filter takes {valid}"
        if self._info is None:
            return f"no CostmapFilterInfo has come on {absolute(topic)}"
        return "" if self._mask else f"no mask has come on {absolute(self._info.mask_topic)}"

    def problem(self, now: float) -> str:
        """Return why the mask cannot be placed."""
        return self._problem

    def _locate(self) -> SE2 | None:
        """Return where the mask's frame lies in the costmap's; None where nobody knows."""
        assert self._mask is not None
        try:
            T_global_mask, self._problem = self.master.locate(self._mask.frame_id), ""
        except TransformError as error:
            self._problem = str(error)
            return None
        return T_global_mask

    def _value_at(self, T_global_base: SE2) -> int | None:
        """Return the mask's value where the robot is, -1 for unknown; None outside it."""
        if self._mask is None or (T_global_mask := self._locate()) is None:
            return None
        place = T_global_mask.inverse() @ T_global_base
        grid = self._mask.grid
        row, column = grid.frame.to_cell(place.x, place.y)
        return int(np.int8(grid.data[row, column])) if grid.frame.contains(row, column) else None
