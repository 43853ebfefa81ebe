"""Random lists of layers and sources, against what Nav2's published rules say, cell by cell."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.raycast import line_cells
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import FREE, LETHAL, UNKNOWN, CostmapConfig, LayeredCostmap, PlacedScan
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.layers import costmap_config

SIZE, CELL = 60, 0.1
FRAME = GridFrame(CELL, SIZE, SIZE, SE2(-3.0, -3.0))
RADIUS, PADDING = 0.25, 0.01
KINDS = ("StaticLayer", "ObstacleLayer", "DenoiseLayer", "InflationLayer")
Costs = NDArray[np.uint8]


def random_source(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "marking": bool(rng.random() < 0.8),
        "clearing": bool(rng.random() < 0.8),
        "inf_is_valid": bool(rng.random() < 0.5),
        "max_obstacle_height": float(rng.choice([0.1, 2.0])),
        "obstacle_max_range": float(rng.uniform(1.0, 3.0)),
        "obstacle_min_range": float(rng.uniform(0.0, 0.5)),
        "raytrace_max_range": float(rng.uniform(1.0, 4.5)),
        "raytrace_min_range": float(rng.uniform(0.0, 0.5)),
    }


def random_layer(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    values: dict[str, Any] = {"plugin": f"nav2_costmap_2d::{kind}"}
    values["enabled"] = bool(rng.random() < 0.9)
    if kind == "ObstacleLayer":
        names = [f"lidar{k}" for k in range(rng.integers(1, 4))]
        values |= {
            "moving_time": 0.0,
            "observation_sources": " ".join(names),
            "combination_method": int(rng.integers(0, 3)),
            "footprint_clearing_enabled": bool(rng.random() < 0.5),
            **{name: random_source(rng) for name in names},
        }
    if kind == "InflationLayer":
        values |= {
            "inflation_radius": float(rng.uniform(0.1, 0.8)),
            "cost_scaling_factor": float(rng.uniform(1.0, 8.0)),
            "inflate_unknown": bool(rng.random() < 0.5),
            "inflate_around_unknown": bool(rng.random() < 0.3),
        }
    if kind == "DenoiseLayer":
        values |= {
            "minimal_group_size": int(rng.integers(1, 5)),
            "group_connectivity_type": int(rng.choice([4, 8])),
        }
    return values


def random_costmap(rng: np.random.Generator) -> CostmapConfig:
    kinds = [str(kind) for kind in rng.choice(KINDS, rng.integers(1, 6))]
    layers = {f"a{k}_{kind[:3]}": random_layer(kind, rng) for k, kind in enumerate(kinds)}
    return costmap_config(
        resolution=CELL,
        width=6,
        height=6,
        origin_x=-3.0,
        origin_y=-3.0,
        robot_radius=RADIUS,
        footprint_padding=PADDING,
        track_unknown_space=bool(rng.random() < 0.5),
        use_maximum=bool(rng.random() < 0.3),
        plugins=list(layers),
        **layers,
    )


def random_scan(rng: np.random.Generator, pose: SE2) -> PlacedScan:
    ranges = rng.uniform(0.05, 3.5, 40)
    ranges[rng.random(40) < 0.2] = math.inf
    mount = SE2(float(rng.uniform(-0.2, 0.2)), 0.0, float(rng.choice([0.0, math.pi])))
    scan = Scan(ranges, -1.5, 3.0 / 40, 0.1, 3.2, T_base_sensor=mount)
    return PlacedScan(scan, pose, height=0.2)


class Plain:
    """A costmap as Nav2 makes it, without any care for time.

    Source: nav2_costmap_2d's layers (`updateBounds`, `updateCosts`, `updateWithMax` ...).
    """

    def __init__(self, config: CostmapConfig) -> None:
        self.config = config
        self.untouched = UNKNOWN if config.track_unknown_space else FREE
        self.map = np.full(FRAME.shape, self.untouched, np.uint8)
        self.own = {n: np.full(FRAME.shape, self.untouched, np.uint8) for n in config.plugins}

    def set_map(self, grid: OccupancyGrid) -> None:
        values = {-1: self.untouched, 0: FREE, 50: FREE, 100: LETHAL}
        self.map = np.vectorize(values.get)(grid.data).astype(np.uint8)

    def update(self, pose: SE2, seen: dict[tuple[str, str], PlacedScan]) -> Costs:
        costs = np.full(FRAME.shape, self.untouched, np.uint8)
        for name in self.config.plugins:
            layer = getattr(self.config, name)
            if not layer.enabled:
                continue
            if layer.plugin.endswith("ObstacleLayer"):
                own = {key[1]: scan for key, scan in seen.items() if key[0] == name}
                self._see(self.own[name], layer, pose, own)
                self._combine(costs, self.own[name], layer.combination_method)
            elif layer.plugin.endswith("StaticLayer"):
                if self.config.use_maximum:
                    self._combine(costs, self.map, 1)
                else:
                    costs[:] = self.map
            elif layer.plugin.endswith("DenoiseLayer"):
                self._denoise(costs, layer)
            else:
                self._inflate(costs, layer)
        return costs

    @staticmethod
    def _combine(costs: Costs, own: Costs, method: int) -> None:
        below = costs == UNKNOWN
        takes = (own > costs) | below if method else np.ones(FRAME.shape, np.bool_)
        takes &= (own != UNKNOWN) & ~(below & (method == 2))
        costs[takes] = own[takes]

    def _see(self, own: Costs, layer: Any, pose: SE2, seen: dict[str, PlacedScan]) -> None:
        used = {
            name: one
            for name, one in seen.items()
            if one.height <= getattr(layer, name).max_obstacle_height
        }
        for name, one in used.items():
            source = getattr(layer, name)
            for bearing, distance in zip(one.reading.angles, one.reading.ranges, strict=True):
                if source.clearing:
                    self._clear(own, one, float(bearing), float(distance), source)
        for name, one in used.items():
            source = getattr(layer, name)
            for bearing, distance in zip(one.reading.angles, one.reading.ranges, strict=True):
                hit = one.reading.range_min <= distance < one.reading.range_max
                near = source.obstacle_min_range <= distance <= source.obstacle_max_range
                cell = self._cell(one, float(bearing), float(distance) if hit else 0.0)
                if source.marking and hit and near and FRAME.contains(*cell):
                    own[cell] = LETHAL
        if layer.footprint_clearing_enabled:
            corners = Footprint.circle(RADIUS, PADDING).at(pose)
            own[_inside(corners)] = FREE

    def _clear(
        self, own: Costs, seen: PlacedScan, bearing: float, distance: float, source: Any
    ) -> None:
        scan = seen.reading
        hit = scan.range_min <= distance < scan.range_max
        if not hit and not (distance >= scan.range_max and source.inf_is_valid):
            return
        length = min(distance, source.raytrace_max_range, scan.range_max)
        if length <= source.raytrace_min_range:
            return
        start = self._cell(seen, bearing, source.raytrace_min_range)
        end = self._cell(seen, bearing, length)
        spared = end if hit and distance <= source.raytrace_max_range else None
        for cell in line_cells(*start, *end):
            if cell != spared and FRAME.contains(*cell):
                own[cell] = FREE

    @staticmethod
    def _cell(seen: PlacedScan, bearing: float, distance: float) -> tuple[int, int]:
        sensor = seen.T_global_sensor
        turned = sensor.theta + bearing
        return FRAME.to_cell(
            sensor.x + distance * math.cos(turned), sensor.y + distance * math.sin(turned)
        )

    @staticmethod
    def _denoise(costs: Costs, layer: Any) -> None:
        shape = np.ones((3, 3)) if layer.group_connectivity_type == 8 else None
        groups, count = ndimage.label(costs == LETHAL, shape)
        for group in range(1, count + 1):
            if (groups == group).sum() < layer.minimal_group_size:
                costs[groups == group] = FREE

    @staticmethod
    def _inflate(costs: Costs, layer: Any) -> None:
        if layer.inflate_around_unknown:
            costs[costs == UNKNOWN] = LETHAL
        if not (costs == LETHAL).any():
            return
        reach = math.ceil(layer.inflation_radius / CELL - 1e-9)
        cells = ndimage.distance_transform_edt(costs != LETHAL)
        inscribed = Footprint.circle(RADIUS, PADDING).inscribed_radius
        for cell in zip(*np.nonzero((cells > 0) & (cells <= reach)), strict=True):
            distance = math.sqrt(round(cells[cell] ** 2)) * CELL
            beyond = int(252 * math.exp(-layer.cost_scaling_factor * (distance - inscribed)))
            cost = 253 if distance <= inscribed else beyond
            if costs[cell] == UNKNOWN:
                if cost >= (1 if layer.inflate_unknown else 253):
                    costs[cell] = cost
            elif cost > costs[cell]:
                costs[cell] = cost


def _inside(corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the cells whose middles lie in a polygon."""
    x, y = FRAME.to_points(np.argwhere(np.ones(FRAME.shape))).T
    sides = np.array(
        [
            (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        ]
    )
    return ((sides > 0).all(axis=0) | (sides < 0).all(axis=0)).reshape(FRAME.shape)


@pytest.mark.parametrize("seed", range(12))
def test_any_list_of_layers_and_sources_is_as_nav2s_rules_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    config = random_costmap(rng)
    layered, plain = LayeredCostmap(config), Plain(config)
    data = rng.choice([-1, 0, 0, 0, 50, 100], FRAME.shape).astype(np.int8)
    layered.set_map(OccupancyGrid(FRAME, data))
    plain.set_map(OccupancyGrid(FRAME, data))
    latest: dict[tuple[str, str], PlacedScan] = {}
    for k in range(4):
        x, y, yaw = rng.uniform((-2.0, -2.0, -3.0), (2.0, 2.0, 3.0)).tolist()
        pose = SE2(x, y, yaw)
        fresh = set()
        for name, layer in layered.layers.items():
            for one in (one for one in layer.inputs() if one.data_type == "LaserScan"):
                for _ in range(rng.integers(0, 3)):
                    latest[name, one.source] = random_scan(rng, pose)
                    layered.receive(name, one.source, latest[name, one.source])
                    fresh.add(name)
        layered.update(pose, float(k))
        # a layer that gets nothing new is as it was; Nav2 enters the same scans again
        seen = {key: scan for key, scan in latest.items() if key[0] in fresh}
        np.testing.assert_array_equal(layered.costmap.data, plain.update(pose, seen))


BACK = SE2(0.0, 0.0, math.pi)


def beams(distance: float, mount: SE2) -> PlacedScan:
    """Return what a lidar sees that looks half a turn round, all at one distance."""
    ranges = np.full(181, distance)
    return PlacedScan(Scan(ranges, -1.57, 3.14 / 180, 0.1, 12.0, T_base_sensor=mount), SE2())


@pytest.mark.parametrize("together", [True, False])
def test_each_of_two_lidars_marks_and_clears_what_it_sees_alone(together: bool) -> None:
    source = {"clearing": True, "max_obstacle_height": 2.0}
    both = {"observation_sources": "front rear", "front": source, "rear": source}
    each = [{"observation_sources": name, name: source} for name in ("front", "rear")]
    other = {"plugin": "nav2_costmap_2d/ObstacleLayer", **each[1]}
    two = {"obstacle_layer": each[0], "other": other}
    config = costmap_config(
        rolling_window=True,
        resolution=0.05,
        plugins=["obstacle_layer"] if together else ["obstacle_layer", "other"],
        **({"obstacle_layer": both} if together else two),
    )
    layered = LayeredCostmap(config)

    def see(now: float, **distances: float) -> tuple[int | None, int | None]:
        for name, distance in distances.items():
            layer = "other" if name == "rear" and not together else "obstacle_layer"
            layered.receive(layer, name, beams(distance, BACK if name == "rear" else SE2()))
        layered.update(SE2(), now)
        return layered.costmap.cost_at(1.01, 0.01), layered.costmap.cost_at(-1.01, 0.01)

    assert see(0.0, front=1.01, rear=2.0) == (LETHAL, FREE)
    assert see(0.1, rear=2.0) == (LETHAL, FREE), "the rear one does not look ahead"
    assert see(0.2, rear=1.01) == (LETHAL, LETHAL)
    assert see(0.3, front=2.0) == (FREE, LETHAL)
    assert see(0.4, rear=2.0) == (FREE, FREE)
