"""The layer that holds layers: they are combined among themselves first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param, plugin_names
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.layers.base import Input, Layer, Master, combine
from arjuna_nav.costmap.layers.plugins import LAYERS
from arjuna_nav.costmap.window import Window, joined


@dataclass(frozen=True)
class ContainerConfig:
    """Parameters of the plug-in container layer; those of its layers stand below their names."""

    enabled: bool = param(True, "Whether the layer takes part.")
    plugins: tuple[str, ...] = plugin_names((), "Layers in order.", LAYERS)
    combination_method: int = param(
        1,
        "How their costs and those of the layers before it combine: 0 its own, 1 the greater,"
        " 2 the greater where theirs are known.",
        choices=(0, 1, 2),
    )


class PluginContainerLayer(Layer):
    """Composes layers of its own as a costmap does, then combines the result with those before it.

    Source: nav2_costmap_2d, plug-in container layer.
    """

    Config: ClassVar[type[Any]] = ContainerConfig

    def __init__(self, config: Any, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._layers: dict[str, Layer] = {
            one: LAYERS.make(getattr(config, one), f"{name}.{one}", master)
            for one in config.plugins
        }

    @property
    def _enabled(self) -> list[Layer]:
        return [layer for layer in self._layers.values() if layer.enabled]

    @property
    def reach(self) -> int:
        """How far a changed cell changes others [cells]."""
        return sum(layer.reach for layer in self._enabled)

    @property
    def frame(self) -> GridFrame | None:
        """Where the costmap has to lie for the last of its layers that needs that."""
        frames = [layer.frame for layer in self._layers.values() if layer.frame is not None]
        return frames[-1] if frames else None

    def inputs(self) -> tuple[Input, ...]:
        """Return what its layers listen to, the sources by `layer.source`."""
        return tuple(
            Input(f"{name}.{i.source}", i.topic, i.data_type, i.sensor_frame, i.latched)
            for name, layer in self._layers.items()
            for i in layer.inputs()
        )

    def receive(self, source: str, value: Any) -> None:
        """Hand what has come to the layer it is for."""
        name, _, rest = source.partition(".")
        self._layers[name].receive(rest, value)

    def start(self, now: float) -> None:
        """Begin at a time [s]."""
        for layer in self._layers.values():
            layer.start(now)

    def missing(self) -> str:
        """Return what has not come to the first layer that lacks something."""
        return next(filter(None, (layer.missing() for layer in self._enabled)), "")

    def problem(self, now: float) -> str:
        """Return why the first layer that is not current is not."""
        return next(filter(None, (layer.problem(now) for layer in self._enabled)), "")

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        """Update its layers."""
        changed = None
        for layer in self._enabled:
            changed = joined(changed, layer.update(T_global_base, now))
        return changed

    def write(self, costs: NDArray[np.uint8], window: Window) -> None:
        """Compose its layers, and combine the result with the costs of those before it."""
        own = np.full(costs.shape, self.master.untouched, dtype=np.uint8)
        for layer in self._enabled:
            layer.write(own, window)
        combine(costs, own, self.config.combination_method)

    def move(self, frame: GridFrame) -> None:
        """Go on in another grid."""
        for layer in self._layers.values():
            layer.move(frame)

    def on_footprint(self) -> None:
        """Take another outline of the robot."""
        for layer in self._layers.values():
            layer.on_footprint()

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        """Forget what sensors have seen."""
        for layer in self._layers.values():
            layer.clear(window, outside)
