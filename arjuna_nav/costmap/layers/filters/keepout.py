"""The filter that keeps the robot out of zones, or has it prefer others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import INSCRIBED, LETHAL, MAX_NON_OBSTACLE, UNKNOWN
from arjuna_nav.costmap.layers.base import Master, combine
from arjuna_nav.costmap.layers.filters.base import UNKNOWN_MASK, CostmapFilter, FilterConfig
from arjuna_nav.costmap.layers.placement import PlacedMap, Placement
from arjuna_nav.costmap.window import Window, whole


@dataclass(frozen=True)
class KeepoutConfig(FilterConfig):
    """Parameters of the keepout filter."""

    override_lethal_cost: bool = param(
        False, "Whether a robot that stands in a zone may drive out of it."
    )
    lethal_override_cost: int = param(
        MAX_NON_OBSTACLE, "What a zone costs then.", minimum=0, maximum=MAX_NON_OBSTACLE
    )


class KeepoutFilter(CostmapFilter):
    """Raises costs to those of a mask: 100 is lethal, what is less costs as much of it.

    Source: nav2_costmap_2d, keepout filter.
    """

    Config: ClassVar[type[Any]] = KeepoutConfig
    TYPES = (0,)

    def __init__(self, config: KeepoutConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._costs: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)  # of the mask's cells
        self._made_of: tuple[PlacedMap, bool] | None = None  # the mask, and if overridden
        self._placement: Placement | None = None
        self._shown = self._costs  # of the costmap's cells

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        """Place the mask by the latest transform."""
        before = self._placement
        T_global_mask = self._locate() if self._mask is not None else None
        if self._mask is None or T_global_mask is None:
            self._placement = None
        else:
            self._weigh(self._mask, T_global_base)
            if self._placement is None or self._placement.T_global_map != T_global_mask:
                self._place(T_global_mask)
        return whole(self.master.frame.shape) if self._placement is not before else None

    def write(self, costs: NDArray[np.uint8], window: Window) -> None:
        """Take the mask's costs where they are greater."""
        if self._placement is not None:
            if self._placement.frame != self.master.frame:
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

    def _place(self, T_global_mask: SE2) -> None:
        """Read the mask's costs at the costmap's cells."""
        assert self._mask is not None
        self._placement = Placement(self.master.frame, T_global_mask, self._mask.grid.frame)
        self._shown = self._placement.read(self._costs, UNKNOWN)


def _is_zone(costs: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Return which costs keep a robot out."""
    zone: NDArray[np.bool_] = (costs == INSCRIBED) | (costs == LETHAL)
    return zone


def _costs_of(data: NDArray[Any]) -> NDArray[np.uint8]:
    """Return what a mask's values cost, `uint8`."""
    costs = np.round(data.astype(np.float64) * LETHAL / 100.0)
    return np.where(data == UNKNOWN_MASK, UNKNOWN, costs).astype(np.uint8)
