"""Layers in a layer, layers of one's own, and what the order of a list means."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load, param
from arjuna_core.errors import ConfigError
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import FREE, LETHAL, UNKNOWN, CostmapConfig, LayeredCostmap, PlacedScan
from arjuna_nav.costmap.layers.base import Layer
from arjuna_nav.costmap.window import Window
from tests.helpers.nav.layers import costmap_config, scans

GRID = OccupancyGrid(GridFrame(0.1, 40, 40, SE2(-2.0, -2.0)), np.zeros((40, 40), np.int8))


@dataclass(frozen=True)
class GradientConfig:
    enabled: bool = param(True, "Whether the layer takes part.")
    step: int = param(10, "Cost from one row to the next.", minimum=0)


class Gradient(Layer):
    """Costs that rise with the row, as that of Nav2's tutorial."""

    Config: ClassVar[type[Any]] = GradientConfig

    def write(self, costs: NDArray[np.uint8], window: Window) -> None:
        rows = np.arange(window[0].start, window[0].stop)
        costs[:] = np.maximum(costs, (rows * self.config.step % 250)[:, None]).astype(np.uint8)


def beam(distance: float) -> PlacedScan:
    return PlacedScan(Scan(np.array([distance]), 0.0, 0.01, 0.1, 12.0), SE2())


def test_a_layer_of_ones_own_stands_among_the_others() -> None:
    mine = {"plugin": f"{__name__}:Gradient", "step": 3}
    config = costmap_config(plugins=("static_layer", "obstacle_layer", "mine"), mine=mine)
    layered = LayeredCostmap(config)
    layered.set_map(GRID)
    rows = np.repeat(3 * np.arange(40)[:, None], 40, axis=1)
    np.testing.assert_array_equal(layered.costmap.data, rows)
    layered.receive("obstacle_layer", "scan", beam(1.05))
    layered.update(SE2(), 0.0)
    assert layered.costmap.cost_at(1.05, 0.05) == LETHAL
    rows[20, 30] = LETHAL
    np.testing.assert_array_equal(layered.costmap.data, rows)


@pytest.mark.parametrize("inflates_last", [True, False])
def test_what_is_listed_after_the_inflation_is_not_inflated(inflates_last: bool) -> None:
    names = ["static_layer", "obstacle_layer"]
    names.insert(2 if inflates_last else 0, "inflation_layer")
    layered = LayeredCostmap(costmap_config(plugins=names))
    layered.set_map(GRID)
    layered.receive("obstacle_layer", "scan", beam(1.05))
    layered.update(SE2(), 0.0)
    assert layered.costmap.cost_at(1.05, 0.05) == LETHAL
    assert (layered.costmap.cost_at(1.05, 0.15) != FREE) is inflates_last
    assert (layered.costmap.circumscribed_cost > 0) is inflates_last


@pytest.mark.parametrize(("method", "expected"), [(0, 33), (1, LETHAL), (2, LETHAL)])
def test_a_container_combines_its_layers_first(method: int, expected: int) -> None:
    config = costmap_config(
        resolution=0.1,
        plugins=("static_layer", "inside"),
        inside={
            "plugin": "nav2_costmap_2d::PluginContainerLayer",
            "plugins": ["obstacle_layer", "mine"],
            "combination_method": method,
            "obstacle_layer": scans(footprint_clearing_enabled=False),
            "mine": {"plugin": f"{__name__}:Gradient", "step": 3},
        },
    )
    layered = LayeredCostmap(config)
    data = GRID.data.copy()
    data[11, 5] = 100
    layered.set_map(OccupancyGrid(GRID.frame, data))
    assert [one.source for one in layered.layers["inside"].inputs()] == ["obstacle_layer.scan"]
    layered.receive("inside", "obstacle_layer.scan", beam(1.05))
    layered.update(SE2(), 0.0)
    assert layered.costmap.data[11, 5] == expected
    assert layered.costmap.cost_at(1.05, 0.05) == LETHAL
    layered.clear_entirely()
    assert layered.costmap.cost_at(1.05, 0.05) == 60


def test_what_changes_in_a_container_is_as_if_all_were_made_again() -> None:
    plugin = "nav2_costmap_2d::PluginContainerLayer"
    inside = {"plugin": plugin, "plugins": ["obstacle_layer", "inflation_layer"]}
    layers = {"obstacle_layer": scans(), "inflation_layer": {"inflation_radius": 0.6}}
    layered = LayeredCostmap(
        costmap_config(plugins=("static_layer", "inside"), inside=inside | layers)
    )
    layered.set_map(GRID)
    for k, distance in enumerate((1.05, 1.25, 1.65)):
        layered.receive("inside", "obstacle_layer.scan", beam(distance))
        layered.update(SE2(), float(k))
        windowed = layered.costmap.data.copy()
        assert (windowed > FREE).sum() > 50
        layered.compose_again()
        np.testing.assert_array_equal(layered.costmap.data, windowed)


def test_a_container_without_layers_knows_nothing() -> None:
    plugin = {"plugin": "nav2_costmap_2d::PluginContainerLayer", "combination_method": 0}
    config = costmap_config(plugins=("empty",), track_unknown_space=True, empty=plugin)
    assert (LayeredCostmap(config).costmap.data == UNKNOWN).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"plugins": ["mine"], "mine.plugin": "mine"},
            "'mine.plugin': no layer 'mine'",
        ),
        ({"plugins": ["mine"]}, "'mine.plugin' must name the class of the layer; valid: contact"),
        ({"plugins": ["static_layr"]}, "'static_layr.plugin' must name .* mean 'static_layer'"),
        ({"plugins": ["a"], "a.plugin": "nav2_costmap_2d/StaticLayr"}, "no layer 'nav2_costmap_2d"),
        ({"obstacle_layer.observation_sources": "a.b"}, "'a.b' is no name of a plug-in"),
        ({"obstacle_layer.observation_sources": ["a"]}, "must be str, got"),
        ({"obstacle_layer.front.topic": "/x"}, "unknown parameter 'obstacle_layer.front.topic'"),
        ({"obstacle_layer.combination_method": 3}, "is 3; valid: 0, 1, 2"),
    ],
)
def test_mistakes_in_lists_are_said(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load(CostmapConfig, values)


def test_a_sources_topic_is_its_name_if_nobody_says_otherwise() -> None:
    seen = {"observation_sources": "front rear", "rear": {"topic": "/b"}}
    config: Any = load(CostmapConfig, {"plugins": ["obstacle_layer"], "obstacle_layer": seen})
    assert config.obstacle_layer.front.topic == "front"
    assert config.scan_topics == {
        "obstacle_layer.front.topic": "front",
        "obstacle_layer.rear.topic": "/b",
    }
