"""The parameters that ship for the Arjuna robot agree with each other and with its body."""

from __future__ import annotations

import math
from typing import Any

import pytest

from arjuna_core.config import load
from arjuna_nav.costmap import CostmapConfig
from arjuna_nav.costmap.footprint import Footprint
from bringup.parameters.files import for_node, shipped_parameters

COSTMAPS = ("global_costmap/global_costmap", "local_costmap/local_costmap")
WHEELBASE, TRACK, WHEEL_RADIUS, WHEEL_WIDTH = 0.30, 0.34, 0.05, 0.04


@pytest.fixture(params=COSTMAPS)
def costmap(request: pytest.FixtureRequest) -> CostmapConfig:
    name: str = request.param
    return load(CostmapConfig, for_node(shipped_parameters(), name), name)


def test_the_footprint_holds_the_whole_body(costmap: CostmapConfig) -> None:
    footprint = Footprint.parse(costmap.footprint, costmap.robot_radius, costmap.footprint_padding)
    wheels = math.hypot(WHEELBASE / 2 + WHEEL_RADIUS, TRACK / 2 + WHEEL_WIDTH / 2)
    body = math.hypot(0.45 / 2, 0.30 / 2)
    assert footprint.inscribed_radius >= max(wheels, body)


def test_the_inflation_reaches_beyond_the_robot(costmap: Any) -> None:
    size = costmap.robot_radius + costmap.footprint_padding
    assert costmap.inflation_layer.inflation_radius > size + 0.1
