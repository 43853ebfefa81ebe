"""The layer that spreads cost round lethal cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.config import length_param, param
from arjuna_core.grid import GridFrame
from arjuna_nav.costmap.inflation import Inflation, clearances, cost_at_distance
from arjuna_nav.costmap.layers.base import Layer, Master
from arjuna_nav.costmap.window import Window


@dataclass(frozen=True)
class InflationConfig:
    """Parameters of the inflation layer."""

    enabled: bool = param(True, "Whether the layer takes part.")
    inflation_radius: float = length_param(
        0.55, "Distance over which cost is spread.", maximum=20.0
    )
    cost_scaling_factor: float = param(
        10.0, "Decay of the cost beyond the inscribed radius.", unit="1/m", minimum=0.0
    )
    inflate_unknown: bool = param(False, "Whether unknown cells take inflated cost.")
    inflate_around_unknown: bool = param(
        False, "Whether cost spreads from unknown cells too, which become lethal."
    )


class InflationLayer(Layer):
    """Spreads cost from what the layers before it marked; what later ones mark is not inflated.

    Source: nav2_costmap_2d, inflation layer.
    """

    Config: ClassVar[type[Any]] = InflationConfig

    def __init__(self, config: InflationConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._inflation = self._make(master.frame.resolution)

    def reconfigure(self, config: Any) -> None:
        super().reconfigure(config)
        self.on_footprint()

    @property
    def reach(self) -> int:
        return self._inflation.reach

    def warning(self) -> str:
        radius, inner = self.config.inflation_radius, self.master.footprint.inscribed_radius
        if radius >= inner:
            return ""
        text = f"inflation_radius {radius:g} m is less than the inscribed radius of the footprint,"
        return f"{text} {inner:.3g} m: the robot may touch what its costs let it pass"

    def write(self, costs: Bytes, window: Window) -> None:
        self._inflation.apply(costs)

    def move(self, frame: GridFrame) -> None:
        if frame.resolution != self.master.frame.resolution:
            self._inflation = self._make(frame.resolution)

    def on_footprint(self) -> None:
        self._inflation = self._make(self.master.frame.resolution)

    def circumscribed_cost(self) -> int:
        """Return the cost below which no heading collides, 0 beyond the inflation's reach."""
        outline, cell = self.master.footprint, self.master.frame.resolution
        radius = outline.circumscribed_radius + cell  # centres of cells against corners of cells
        if radius > self.config.inflation_radius:
            return 0
        return cost_at_distance(radius, outline.inscribed_radius, self.config.cost_scaling_factor)

    def clearances(self) -> Floats:
        """Return how far from an obstacle a robot is by the cost, as `clearances` does."""
        return clearances(self.config.cost_scaling_factor)

    def _make(self, resolution: float) -> Inflation:
        config = self.config
        return Inflation(
            config.inflation_radius,
            config.cost_scaling_factor,
            self.master.footprint.inscribed_radius,
            resolution,
            config.inflate_unknown,
            config.inflate_around_unknown,
        )
