"""The protocol of a costmap's layers, and the state that they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Bytes
from arjuna_core.config import param
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.transforms import TransformError
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import FREE, UNKNOWN
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.moving.tracker import Moving
from arjuna_nav.costmap.window import Window, clipped

C = TypeVar("C", np.uint8, np.uint32)


@dataclass(frozen=True)
class Input:
    """A topic that a layer listens to.

    Attributes:
        source: The layer's name for it, as `receive` has it.
        topic: Its name; a relative one lies outside the costmap's own namespace, as in Nav2.
        data_type: `LaserScan`, `PointCloud2`, `Range`, `Twist`, `TwistStamped`, `OccupancyGrid`,
            `OccupancyGridUpdate` or `CostmapFilterInfo`.
        sensor_frame: Where its rays start; empty for the frame of its messages.
        latched: Whether its publisher keeps the last message for those who come late.
    """

    source: str
    topic: str
    data_type: str
    sensor_frame: str = ""
    latched: bool = False


def _no_transform(target: str, source: str) -> SE2:
    raise TransformError(f"no transform connects '{target}' and '{source}'")


@dataclass
class Master:
    """State that the layers of a costmap share.

    Attributes:
        body: The robot's own outline; None where the footprint without padding is that.
        hits: `(height, width) uint32` where in its cell each mark lies, as `hit_points` reads it.
        moving: What moves, by who follows it: a layer and its source.
        moving_times: How far ahead the paths of what moves count, likewise [s].
        transform: Returns the latest `T_target_source` of two frames; raises a TransformError.
    """

    config: CostmapConfig
    frame: GridFrame
    footprint: Footprint
    body: Footprint | None
    hits: NDArray[np.uint32]
    moving: dict[str, Moving] = field(default_factory=dict)
    moving_times: dict[str, float] = field(default_factory=dict)
    transform: Callable[[str, str], SE2] = _no_transform

    @property
    def untouched(self) -> int:
        """Cost of a cell of which nothing is known."""
        return UNKNOWN if self.config.track_unknown_space else FREE

    def locate(self, frame_id: str) -> SE2:
        """Return where a frame lies in the costmap's; empty for the costmap's own.

        Raises:
            TransformError: It is not known.
        """
        own = self.config.global_frame
        return IDENTITY if frame_id in ("", own) else self.transform(own, frame_id)


class Layer:
    """A layer of a costmap; one of a user's own derives from it and writes what differs.

    Attributes:
        Config: The frozen dataclass of its parameters, which has a field `enabled`.
        name: Its name in the costmap's `plugins`.
        master: What it shares with the others.
    """

    Config: ClassVar[type[Any]]
    config: Any
    name: str
    master: Master

    def __init__(self, config: Any, name: str, master: Master) -> None:
        self.config, self.name, self.master = config, name, master

    @property
    def enabled(self) -> bool:
        """The layer's `enabled` parameter: else it leaves the costmap as it is."""
        return bool(self.config.enabled)

    @property
    def reach(self) -> int:
        """Distance over which a changed cell below changes this layer [cells]."""
        return 0

    @property
    def frame(self) -> GridFrame | None:
        """The grid it needs of a costmap that does not follow the robot; None for any."""
        return None

    def inputs(self) -> tuple[Input, ...]:
        """Return what it listens to."""
        return ()

    def receive(self, source: str, value: Any) -> None:
        """Take what has come from a source; it counts from the next update on."""

    def start(self, now: float) -> None:
        """Begin at a time [s]: what was received before does not count."""

    def missing(self) -> str:
        """Return what has not come and without which the costmap cannot begin; empty for none."""
        return ""

    def problem(self, now: float) -> str:
        """Return why what it holds is not current at a time [s]; empty where it is."""
        return ""

    def warning(self) -> str:
        """Return what is odd about it, though the costs are current; empty for nothing."""
        return ""

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        """Enter what was received.

        Args:
            T_global_base: Pose of the robot in the costmap's global frame.
            now: Time of the update [s].

        Returns:
            The cells that have changed, at least; None where none has.
        """
        return None

    def write(self, costs: Bytes, window: Window) -> None:
        """Write its costs over those of the layers before it, in place.

        Args:
            costs: Of the window's cells, `(rows, columns) uint8`.
        """

    def own_costs(self) -> Bytes | None:
        """Return what it alone knows, of the costmap's cells; None where it keeps no costs."""
        return None

    def move(self, frame: GridFrame) -> None:
        """Continue in another grid of the same resolution; `master.frame` is still the old one."""

    def on_footprint(self) -> None:
        """Take another outline of the robot: `master.footprint`."""

    def reconfigure(self, config: Any) -> None:
        """Take other parameters; one that computes from them at the start computes again."""
        self.config = config

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        """Forget what sensors have seen: everywhere, in a window, or outside that window."""


class SensedLayer(Layer):
    """Keeps what sensors have seen on a grid of its own.

    Attributes:
        data: `(height, width) uint8`.
    """

    def __init__(self, config: Any, name: str, master: Master, untouched: int) -> None:
        super().__init__(config, name, master)
        self._untouched = untouched
        self._received: dict[str, list[Any]] = {one.source: [] for one in self.inputs()}
        self._received_at = dict.fromkeys(self._received, -math.inf)
        self.data: Bytes = np.full(master.frame.shape, untouched, dtype=np.uint8)

    def receive(self, source: str, value: Any) -> None:
        self._received[source].append(value)

    def start(self, now: float) -> None:
        """Begin at a time [s]: no source is silent yet."""
        self._received = {source: [] for source in self._received}
        self._received_at = dict.fromkeys(self._received_at, now)

    def move(self, frame: GridFrame) -> None:
        self.data = moved(self.data, self.master.frame, frame, self._untouched)

    def clear(self, window: Window | None = None, outside: bool = False) -> None:
        if window is None:
            self.data.fill(self._untouched)
            return
        kept = self.data[window].copy() if outside else None
        (self.data if outside else self.data[window]).fill(self._untouched)
        if kept is not None:
            self.data[window] = kept

    def own_costs(self) -> Bytes | None:
        return self.data

    def _take(self, now: float) -> dict[str, list[Any]]:
        """Return what has come since the last update [s], by source."""
        received = self._received
        self._received = {source: [] for source in received}
        self._received_at |= {source: now for source, values in received.items() if values}
        return received

    def _window(self, boxes: Sequence[tuple[SE2, float]]) -> Window:
        """Return the cells within given distances of poses [m]."""
        cell, T_grid_frame = self.master.frame.resolution, self.master.frame.origin.inverse()
        placed = [(T_grid_frame @ pose, radius) for pose, radius in boxes]
        x0, y0 = min(p.x - r for p, r in placed), min(p.y - r for p, r in placed)
        x1, y1 = max(p.x + r for p, r in placed), max(p.y + r for p, r in placed)
        rows = math.floor(y0 / cell) - 1, math.ceil(y1 / cell) + 1
        columns = math.floor(x0 / cell) - 1, math.ceil(x1 / cell) + 1
        return clipped(*rows, *columns, self.data.shape)


def absolute(topic: str) -> str:
    """Return a topic outside the costmap's own namespace, as Nav2 resolves it."""
    return topic if topic.startswith("/") else f"/{topic}"


def combination_method(whose: str) -> Any:
    """Declare the parameter of layers whose costs combine with those before them by `combine`."""
    text = (
        f"How {whose} costs and those of the layers before it combine: 0 its own, 1 the greater,"
        " 2 the greater where theirs are known."
    )
    return param(1, text, choices=(0, 1, 2))


def combine(costs: Bytes, own: Bytes, method: int) -> None:
    """Write a layer's costs over others, in place; where a layer knows nothing, the others stay.

    Args:
        own: The layer's, of the same shape.
        method: Nav2's `combination_method`: 0 the layer's, 1 the greater, 2 the greater where the
            others know something.
    """
    known = own != UNKNOWN
    if method == 0:
        take = known
    elif method == 1:
        take = known & ((costs == UNKNOWN) | (own > costs))
    else:
        take = known & (own > costs)  # unknown is the greatest number
    np.copyto(costs, own, where=take)


def moved(data: NDArray[C], old: GridFrame, new: GridFrame, fill: int) -> NDArray[C]:
    """Return what a grid holds on another of the same resolution, where both cover it.

    Args:
        data: `(height, width)`; returned itself where the grids are the same.
        fill: What else the result holds.
    """
    if new == old:
        return data
    result = np.full(new.shape, fill, dtype=data.dtype)
    shift = old.origin.inverse() @ new.origin
    row, column = (round(v / new.resolution) for v in (shift.y, shift.x))
    turned = abs(shift.theta) * max(new.width, new.height) > 0.5
    if new.resolution == old.resolution and not turned:
        _copy_overlap(data, result, row, column)
    return result


def _copy_overlap(old: NDArray[C], new: NDArray[C], row: int, column: int) -> None:
    """Copy what lies in both, where `new[0, 0]` lies at `old[row, column]`."""
    rows = slice(max(row, 0), min(row + new.shape[0], old.shape[0]))
    columns = slice(max(column, 0), min(column + new.shape[1], old.shape[1]))
    if rows.start < rows.stop and columns.start < columns.stop:
        target = (
            slice(rows.start - row, rows.stop - row),
            slice(columns.start - column, columns.stop - column),
        )
        new[target] = old[rows, columns]
