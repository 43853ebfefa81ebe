"""What the layers have in common that keep what sensors have seen, until they see otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.layers.base import Layer, Master, moved
from arjuna_nav.costmap.window import Window, clipped


class SensedLayer(Layer):
    """Keeps what sensors have seen on a grid of its own.

    Args:
        config: Parameters.
        name: Its name.
        master: What it shares with the others.
        untouched: What a cell holds that no sensor has seen.

    Attributes:
        data: `(height, width) uint8`.
    """

    def __init__(self, config: Any, name: str, master: Master, untouched: int) -> None:
        super().__init__(config, name, master)
        self._untouched = untouched
        self._received: dict[str, list[Any]] = {one.source: [] for one in self.inputs()}
        self._heard = dict.fromkeys(self._received, -math.inf)
        self.data: NDArray[np.uint8] = np.full(master.frame.shape, untouched, dtype=np.uint8)

    def receive(self, source: str, value: Any) -> None:
        """Take what a sensor has seen."""
        self._received[source].append(value)

    def start(self, now: float) -> None:
        """Begin at a time [s]: no source is silent yet."""
        self._received = {source: [] for source in self._received}
        self._heard = dict.fromkeys(self._heard, now)

    def move(self, frame: GridFrame) -> None:
        """Go on in another grid of the same resolution; what both cover is kept."""
        self.data = moved(self.data, self.master.frame, frame, self._untouched)

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        """Forget what was seen: everywhere, in a window of cells, or outside that window."""
        if window is None:
            self.data.fill(self._untouched)
            return
        kept = self.data[window].copy() if outside else None
        (self.data if outside else self.data[window]).fill(self._untouched)
        if kept is not None:
            self.data[window] = kept

    def own_costs(self) -> NDArray[np.uint8] | None:
        """Return what sensors have seen."""
        return self.data

    def _take(self, now: float) -> dict[str, list[Any]]:
        """Return what has come since the last update [s], by source."""
        received = self._received
        self._received = {source: [] for source in received}
        self._heard |= {source: now for source, values in received.items() if values}
        return received

    def _window(self, boxes: Sequence[tuple[SE2, float]]) -> Window:
        """Return the cells within given distances of places [m]."""
        frame = self.master.frame
        places = frame.origin.inverse().apply(np.array([(p.x, p.y) for p, _ in boxes]))
        reach = np.array([[radius] for _, radius in boxes])
        low, high = (places - reach).min(axis=0), (places + reach).max(axis=0)
        x0, y0 = (math.floor(v / frame.resolution) - 1 for v in low.tolist())
        x1, y1 = (math.ceil(v / frame.resolution) + 1 for v in high.tolist())
        return clipped(y0, y1, x0, x1, self.data.shape)
