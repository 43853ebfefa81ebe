"""Near goals on large maps: the same path as on all of the map, and no sooner believed."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.planners import PlanStatus, nearby
from arjuna_nav.planners import path as paths
from tests.helpers.nav.navfn_maps import rooms
from tests.helpers.nav.planners import CLASSES, make


@pytest.mark.parametrize("name", CLASSES)
def test_a_near_goal_has_the_path_that_all_of_the_map_gives(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    costmap, planner = rooms(800, 0), make(name)
    rng = np.random.default_rng(1)
    free = np.argwhere(costmap.data[250:550, 250:550] < 100) + 250
    for _ in range(4):
        a, b = free[rng.integers(len(free), size=2)]
        start, goal = (SE2(*costmap.frame.to_point(*cell), 0.3) for cell in (a, b))
        near = planner.plan(costmap, start, goal)
        with monkeypatch.context() as patched:
            patched.setattr(nearby, "_SHARE", 0.0)
            whole = planner.plan(costmap, start, goal)
        assert near.status is whole.status
        if near.status is PlanStatus.SUCCEEDED:
            assert paths.length(near.path) == pytest.approx(paths.length(whole.path), rel=0.02)


@pytest.mark.parametrize("name", CLASSES)
def test_a_near_goal_behind_a_long_wall_is_reached_round_its_end(name: str) -> None:
    data = np.zeros((600, 600), np.uint8)
    data[300:304, :560] = 254
    costmap = Costmap(GridFrame(0.05, 600, 600), data)
    result = make(name).plan(costmap, SE2(10.0, 14.0), SE2(10.0, 16.0))
    assert result.status is PlanStatus.SUCCEEDED
    assert result.path[:, 0].max() > 27.9
    data[300:304] = 254
    assert make(name).plan(costmap, SE2(10.0, 14.0), SE2(10.0, 16.0)).status is not (
        PlanStatus.SUCCEEDED
    )
