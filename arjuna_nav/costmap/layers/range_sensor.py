"""The layer of what sonars and infrared sensors measure: probabilities in cones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numba import njit

from arjuna_core.arrays import Bytes, Floats
from arjuna_core.config import duration_param, fixed, param, share_param
from arjuna_core.scan import RangeReading
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.layers.base import Input, Master, SensedLayer, absolute
from arjuna_nav.costmap.layers.observations import PlacedRange
from arjuna_nav.costmap.window import Window, within

_EVEN = LETHAL // 2  # neither marked nor free
_OVERSHOOT = 1.2  # of the cone's triangle over the distance


@dataclass(frozen=True)
class RangeConfig:
    """Parameters of the range sensor layer."""

    enabled: bool = param(True, "Whether the layer takes part.")
    topics: tuple[str, ...] = fixed((), "Topics of the readings.")
    input_sensor_type: str = param(
        "ALL",
        "Which readings are taken: VARIABLE distances, those of a FIXED one, or both.",
        choices=("ALL", "VARIABLE", "FIXED"),
    )
    phi: float = param(1.2, "Distance beyond which a sensor is believed less.", unit="m")
    inflate_cone: float = share_param(1.0, "Share of a cone's area that cells may lie beside it.")
    clear_threshold: float = share_param(0.2, "Probability below which a cell is free.")
    mark_threshold: float = share_param(0.8, "Probability above which a cell is lethal.")
    clear_on_max_reading: bool = param(False, "Whether a reading of nothing frees its cone.")
    no_readings_timeout: float = duration_param(
        0.0, "Longest silence of all sensors allowed; 0 allows any."
    )


class RangeSensorLayer(SensedLayer):
    """Keeps how likely each cell is occupied, and marks and frees where that is sure enough.

    Source: nav2_costmap_2d, range sensor layer.
    """

    Config: ClassVar[type[Any]] = RangeConfig

    def __init__(self, config: RangeConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master, _EVEN)

    def inputs(self) -> tuple[Input, ...]:
        return tuple(Input(topic, topic, "Range") for topic in self.config.topics)

    def problem(self, now: float) -> str:
        silent = now - max(self._received_at.values(), default=now)
        if not 0.0 < self.config.no_readings_timeout < silent:
            return ""
        return f"no range on {', '.join(map(absolute, self._received_at))} for {silent:.2f} s"

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        readings = [one for several in self._take(now).values() for one in several]
        if not readings:
            return None
        readings.sort(key=lambda one: one.stamp)
        edge = self.master.frame.resolution
        touched = self._window(
            [(one.T_global_sensor, _OVERSHOOT * one.reading.range_max + edge) for one in readings]
        )
        before = self.data[touched].copy()
        for reading in readings:
            self._enter(reading)
        return within(touched, self.data[touched] != before)

    def write(self, costs: Bytes, window: Window) -> None:
        own = self.data[window]
        costs[own > int(self.config.mark_threshold * LETHAL)] = LETHAL
        free = own < int(self.config.clear_threshold * LETHAL)
        costs[free & (costs == UNKNOWN)] = FREE

    def _enter(self, placed: PlacedRange) -> None:
        frame = self.master.frame
        distance, nothing = self._interpreted(placed.reading)
        if distance is None:
            return
        _enter_cone(
            self.data,
            (frame.origin.inverse() @ placed.T_global_sensor).array(),
            (
                distance,
                0.5 * placed.reading.field_of_view,
                self.config.phi,
                self.config.inflate_cone,
            ),
            nothing,
            frame.resolution,
        )

    def _interpreted(self, reading: RangeReading) -> tuple[float | None, bool]:
        """Return the distance, None where it says nothing, and whether nothing is within it."""
        kind = "FIXED" if reading.fixed else "VARIABLE"
        if self.config.input_sensor_type not in ("ALL", kind):
            return None, False
        if reading.fixed:
            nothing = reading.distance > 0.0
            says = math.isinf(reading.distance) and not (
                nothing and not self.config.clear_on_max_reading
            )
            return (reading.range_min if says else None), nothing
        if not reading.range_min <= reading.distance <= reading.range_max:
            return None, False
        farthest = reading.distance == reading.range_max
        return reading.distance, farthest and bool(self.config.clear_on_max_reading)


@njit(cache=True)
def _enter_cone(
    data: Bytes, sensor: Floats, cone: tuple[float, float, float, float], nothing: bool, cell: float
) -> None:
    """Update the probabilities in a cone, in place.

    Args:
        data: `(height, width) uint8` probabilities, 254 for one.
        sensor: `(3,)` x, y, heading of the sensor in the grid [m, m, rad].
        cone: Distance [m], half the angle [rad], where the sensor's belief fades [m], and how
            much of a margin the cone's triangle gets, 1 for all.
        nothing: Whether the cone is free.
        cell: Edge of a cell [m].
    """
    distance, half, fades, inflate = cone
    height, width = data.shape
    far = _OVERSHOOT * distance
    corners = np.empty((3, 2))
    corners[0] = sensor[:2]
    for k, turn in enumerate((-half, half)):
        corners[k + 1, 0] = sensor[0] + far * math.cos(sensor[2] + turn)
        corners[k + 1, 1] = sensor[1] + far * math.sin(sensor[2] + turn)
    tip_x = sensor[0] + distance * math.cos(sensor[2])
    tip_y = sensor[1] + distance * math.sin(sensor[2])
    columns = _span(corners[:, 0], tip_x, cell, width)
    rows = _span(corners[:, 1], tip_y, cell, height)
    for row in range(rows[0], rows[1]):
        for column in range(columns[0], columns[1]):
            x, y = (column + 0.5) * cell, (row + 0.5) * cell
            if inflate < 1.0 and not _within(x, y, corners, inflate):
                continue
            dx, dy = x - sensor[0], y - sensor[1]
            off = (math.atan2(dy, dx) - sensor[2] + math.pi) % (2.0 * math.pi) - math.pi
            occupied = 0.0
            if not nothing:
                occupied = _sensor_model(distance, math.hypot(dx, dy), off, half, fades, cell)
            elif abs(off) > half or math.hypot(dx, dy) > distance * (1.0 + 2.0 * cell) + cell:
                continue
            prior = data[row, column] / LETHAL
            yes, no = occupied * prior, (1.0 - occupied) * (1.0 - prior)
            if yes + no > 0.0:
                data[row, column] = int(yes / (yes + no) * LETHAL)


@njit(cache=True)
def _span(corners: Floats, tip: float, cell: float, size: int) -> tuple[int, int]:
    """Return the first cell of a cone along one axis, and the one after its last."""
    low, high = min(corners.min(), tip), max(corners.max(), tip)
    return max(math.floor(low / cell), 0), min(math.floor(high / cell) + 1, size)


@njit(cache=True)
def _within(x: float, y: float, corners: Floats, inflate: float) -> bool:
    """Return whether a point lies in a triangle, or beside it by a share of its area."""
    (ox, oy), (ax, ay), (bx, by) = corners[0], corners[1], corners[2]
    area = abs((ax - ox) * (by - oy) - (bx - ox) * (ay - oy))
    for x0, y0, x1, y1 in ((ax, ay, bx, by), (bx, by, ox, oy), (ox, oy, ax, ay)):
        if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) < -inflate * area:
            return False
    return True


@njit(cache=True)
def _sensor_model(
    measured: float, at: float, off: float, half: float, fades: float, cell: float
) -> float:
    """Return how likely a reading makes it that a point is occupied, 0.5 where it says nothing.

    Args:
        measured: The reading [m].
        at: The point's distance from the sensor [m].
        off: Its angle off the cone's axis [rad].
        half: Half the cone's angle [rad].
        fades: Distance beyond which the sensor is believed less [m].
        cell: Edge of a cell, by which share a reading errs [m].

    Source: nav2_costmap_2d, RangeSensorLayer::sensor_model.
    """
    aside = 1.0 - (off / half) ** 2 if abs(off) <= half else 0.0
    belief = aside * (1.0 - (1.0 + math.tanh(2.0 * (at - fades))) / 2.0)
    errs = cell * measured
    if at < measured - 2.0 * errs:
        return (1.0 - belief) * 0.5
    if at < measured - errs:
        rise = (at - (measured - 2.0 * errs)) / errs
        return belief * 0.5 * rise * rise + (1.0 - belief) * 0.5
    if at < measured + errs:
        gap = (measured - at) / errs
        return belief * (0.5 - 0.5 * gap * gap) + 0.5
    return 0.5
