"""Groups of layers: a costmap's own, and the layer that combines its layers first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Bytes
from arjuna_core.config import param, plugin_names
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.layers.base import Input, Layer, Master, combination_method, combine
from arjuna_nav.costmap.layers.plugins import LAYERS
from arjuna_nav.costmap.window import Window, joined


@dataclass(frozen=True)
class ContainerConfig:
    """Parameters of the plug-in container layer; those of its layers stand below their names."""

    enabled: bool = param(True, "Whether the layer takes part.")
    plugins: tuple[str, ...] = plugin_names((), "Layers in order.", LAYERS)
    combination_method: int = combination_method("their")


class LayerGroup(Layer):
    """Layers that are composed in order.

    Args:
        config: Which has the parameters of each layer under its name.
        name: Of the group; empty for that of a costmap.
        names: Of the layers, in order.

    Attributes:
        layers: By name.
    """

    Config: ClassVar[type[Any]] = ContainerConfig

    def __init__(self, config: Any, name: str, master: Master, names: Sequence[str]) -> None:
        super().__init__(config, name, master)
        prefix = f"{name}." if name else ""
        self.layers: dict[str, Layer] = {
            one: LAYERS.make(getattr(config, one), f"{prefix}{one}", master) for one in names
        }

    def reconfigure(self, config: Any) -> None:
        super().reconfigure(config)
        for name, layer in self.layers.items():
            layer.reconfigure(getattr(config, name))

    @property
    def in_use(self) -> list[Layer]:
        """The layers that are enabled."""
        return [layer for layer in self.layers.values() if layer.enabled]

    @property
    def reach(self) -> int:
        return sum(layer.reach for layer in self.in_use)

    @property
    def frame(self) -> GridFrame | None:
        frames = [layer.frame for layer in self.layers.values() if layer.frame is not None]
        return frames[-1] if frames else None

    def inputs(self) -> tuple[Input, ...]:
        return tuple(
            replace(one, source=f"{name}.{one.source}")
            for name, layer in self.layers.items()
            for one in layer.inputs()
        )

    def receive(self, source: str, value: Any) -> None:
        name, _, rest = source.partition(".")
        self.layers[name].receive(rest, value)

    def start(self, now: float) -> None:
        for layer in self.layers.values():
            layer.start(now)

    def missing(self) -> str:
        return next(filter(None, (layer.missing() for layer in self.in_use)), "")

    def problem(self, now: float) -> str:
        return next(filter(None, (layer.problem(now) for layer in self.in_use)), "")

    def warning(self) -> str:
        odd = ((layer.name, layer.warning()) for layer in self.in_use)
        return "\n".join(f"{name}: {warning}" for name, warning in odd if warning)

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        changed = None
        for layer in self.in_use:
            changed = joined(changed, layer.update(T_global_base, now))
        return changed

    def write(self, costs: Bytes, window: Window) -> None:
        for layer in self.in_use:
            layer.write(costs, window)

    def move(self, frame: GridFrame) -> None:
        for layer in self.layers.values():
            layer.move(frame)

    def on_footprint(self) -> None:
        for layer in self.layers.values():
            layer.on_footprint()

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        for layer in self.layers.values():
            layer.clear(window, outside)


class PluginContainerLayer(LayerGroup):
    """Composes layers of its own as a costmap does, then combines the result with those before it.

    Source: nav2_costmap_2d, plug-in container layer.
    """

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master, config.plugins)

    def write(self, costs: Bytes, window: Window) -> None:
        own = np.full(costs.shape, self.master.untouched, dtype=np.uint8)
        super().write(own, window)
        combine(costs, own, self.config.combination_method)
