"""The layer of what sonars and infrared sensors tell: probabilities in cones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame
from arjuna_core.readings import RangeReading
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import FREE, LETHAL, UNKNOWN
from arjuna_nav.costmap.layers import SeenLayer
from arjuna_nav.costmap.window import Window

_EVEN = LETHAL // 2  # neither marked nor free
_OVERSHOOT = 1.2  # of the cone's triangle over the distance


@dataclass(frozen=True)
class PlacedRange:
    """A reading and where the robot was when it was taken.

    Attributes:
        reading: The reading.
        T_global_base: Pose of the base in the costmap's global frame at the reading's stamp.
    """

    reading: RangeReading
    T_global_base: SE2


class RangeLayer(SeenLayer[PlacedRange]):
    """Holds how likely each cell is occupied, and marks and frees where that is sure enough.

    Args:
        frame: Where the grid lies.
        config: The costmap's parameters.

    Source: nav2_costmap_2d, range sensor layer.
    """

    def __init__(self, frame: GridFrame, config: CostmapConfig) -> None:
        super().__init__(frame, config)
        self._range = config.range_layer
        self._untouched = _EVEN
        self.clear()

    def merge_into(self, master: NDArray[np.uint8], window: Window) -> None:
        """Take what is surely occupied as lethal, and what is surely free where it is unknown."""
        own = self.data[window]
        master[own > int(self._range.mark_threshold * LETHAL)] = LETHAL
        free = own < int(self._range.clear_threshold * LETHAL)
        master[free & (master == UNKNOWN)] = FREE

    def _free(self, corners: NDArray[np.float64]) -> None:
        """Keep what is known of the robot's own place."""

    def _reach(self, seen: PlacedRange) -> tuple[SE2, float]:
        reading = seen.reading
        sensor = seen.T_global_base @ reading.T_base_sensor
        return sensor, _OVERSHOOT * reading.range_max + self.frame.resolution

    def _enter(self, seen: PlacedRange) -> None:
        reading = seen.reading
        distance, nothing = self._interpreted(reading)
        if distance is None:
            return
        T_grid_sensor = self.frame.origin.inverse() @ seen.T_global_base @ reading.T_base_sensor
        _enter_cone(
            self.data,
            T_grid_sensor.array(),
            (distance, 0.5 * reading.field_of_view, self._range.phi, self._range.inflate_cone),
            nothing,
            self.frame.resolution,
        )

    def _interpreted(self, reading: RangeReading) -> tuple[float | None, bool]:
        """Return the distance, None where it says nothing, and whether nothing is within it."""
        kind = "FIXED" if reading.fixed else "VARIABLE"
        if self._range.input_sensor_type not in ("ALL", kind):
            return None, False
        if reading.fixed:
            nothing = reading.distance > 0.0
            says = math.isinf(reading.distance) and not (
                nothing and not self._range.clear_on_max_reading
            )
            return (reading.range_min if says else None), nothing
        if not reading.range_min <= reading.distance <= reading.range_max:
            return None, False
        farthest = reading.distance == reading.range_max
        return reading.distance, farthest and bool(self._range.clear_on_max_reading)


@njit(cache=True)
def _enter_cone(
    data: NDArray[np.uint8],
    sensor: NDArray[np.float64],
    cone: tuple[float, float, float, float],
    nothing: bool,
    cell: float,
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
def _span(corners: NDArray[np.float64], tip: float, cell: float, size: int) -> tuple[int, int]:
    """Return the first cell of a cone along one axis, and the one after its last."""
    low, high = min(corners.min(), tip), max(corners.max(), tip)
    return max(math.floor(low / cell), 0), min(math.floor(high / cell) + 1, size)


@njit(cache=True)
def _within(x: float, y: float, corners: NDArray[np.float64], inflate: float) -> bool:
    """Tell whether a place lies in a triangle, or beside it by a share of its area."""
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
    """Return how likely a reading makes it that a place is occupied, 0.5 where it says nothing.

    Args:
        measured: The reading [m].
        at: The place's distance from the sensor [m].
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
