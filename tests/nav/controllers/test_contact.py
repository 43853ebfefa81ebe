"""Leaving walls on whose cells the robot's padding stands."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.controllers.contact import bend_off
from arjuna_nav.controllers.escape import Escape, EscapeConfig
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.escape import lead_out
from tests.nav.worlds import block, costmap_of, empty_grid

BODY = np.array([[0.04, 0.09], [-0.1, 0.07], [-0.1, -0.07], [0.04, -0.09]])
PADDED = np.array([[0.06, 0.11], [-0.12, 0.09], [-0.12, -0.09], [0.06, -0.11]])
WALL = 1.375  # the middle of its cells, which is where points are [m]


@pytest.mark.parametrize("origin", [SE2(), SE2(5.0, -3.0, 0.8)])
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["right", "left"])
@pytest.mark.parametrize("turned", [0.0, 0.1])
def test_a_robot_along_a_wall_leaves_it_in_a_bend(origin: SE2, side: float, turned: float) -> None:
    grid = empty_grid(4.0, 3.0, origin)
    block(grid, 0.0, WALL - 0.025 if side > 0.0 else 3.0 - WALL - 0.025, 4.0, 0.05)
    costmap = costmap_of(grid, footprint=str(PADDED.tolist()))
    padded, body = Footprint.polygon(PADDED), Footprint.polygon(BODY)
    own = SE2(2.0, 1.5 + side * (WALL + 0.1 - 1.5), side * turned)
    pose = origin @ own
    assert collides(costmap, padded, pose)
    assert len(lead_out(pose, costmap, padded)) == 1, "straight it gets off"
    poses = bend_off(pose, costmap, padded, body)
    assert len(poses) > 1
    assert not collides(costmap, padded, SE2.from_array(poses[-1]))
    for each in poses:
        corners = (origin.inverse() @ SE2.from_array(each)).apply(BODY)
        assert (side * (corners[:, 1] - 1.5)).min() > WALL - 1.5
    escape = Escape(EscapeConfig(), TrackerConfig(), padded, body)
    assert escape.leave_contact(pose, costmap)


def test_between_walls_there_is_no_bend_and_in_the_free_none_is_needed() -> None:
    grid = empty_grid(4.0, 3.0)
    costmap = costmap_of(grid, footprint=str(PADDED.tolist()))
    padded, body = Footprint.polygon(PADDED), Footprint.polygon(BODY)
    assert not Escape(EscapeConfig(), TrackerConfig(), padded, body).leave_contact(
        SE2(2.0, 1.5), costmap
    )
    for y in (WALL, WALL + 0.2):
        block(grid, 0.0, y - 0.025, 4.0, 0.05)
    costmap = costmap_of(grid, footprint=str(PADDED.tolist()))
    assert len(bend_off(SE2(2.0, WALL + 0.1), costmap, padded, body)) == 1
