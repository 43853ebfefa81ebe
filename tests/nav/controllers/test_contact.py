"""Leaving walls on whose cells the robot's padding stands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.controllers.contact import leaves, line_off, turn_touches
from arjuna_nav.controllers.escape import Escape, EscapeConfig
from arjuna_nav.controllers.follower import FollowerConfig, PathFollower
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.escape import lead_out
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

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
    poses = line_off(pose, costmap, padded, body)
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
    assert len(line_off(SE2(2.0, WALL + 0.1), costmap, padded, body)) == 1


CIRCLE = Footprint.circle(0.28)  # about a body of 0.45 x 0.38 m
CORNERS = np.array([[0.225, 0.15], [0.2, 0.19], [-0.2, 0.19], [-0.225, 0.15]])
LONG = Footprint.polygon(np.vstack((CORNERS, CORNERS[::-1] * (1.0, -1.0))))


def beside(gap: float, radius: float = 0.28) -> Costmap:
    """Return a wall to the left of the origin, at a gap from a body that is as wide as `LONG`."""
    grid = empty_grid(4.0, 4.0, SE2(-2.0, -2.0))
    block(grid, 0.0, 2.25, 4.0, 0.05)  # its points are at 0.275
    return costmap_of(grid, radius).seen_from(SE2(0.0, 0.19 + gap - 0.275))


@pytest.mark.parametrize("gap", [0.005, 0.02])
@pytest.mark.parametrize("heading", [0.0, 0.1, -0.1])
def test_a_body_beside_a_wall_leaves_it_in_a_wide_bend(gap: float, heading: float) -> None:
    pose, turn = SE2(0.0, 0.0, heading), -0.5
    costmap = beside(gap + 0.225 * abs(math.sin(heading)))
    assert turn_touches(pose, turn, costmap, LONG)
    assert not turn_touches(pose, turn, costmap, Footprint.circle(0.19)), "a circle meets nothing"
    poses = line_off(pose, costmap, CIRCLE, LONG, turn=turn)
    end = SE2.from_array(poses[-1])
    assert not collides(costmap, CIRCLE, end)
    assert not turn_touches(end, turn, costmap, LONG)
    wall = costmap.obstacles(0.0, 0.0, 1.0)[:, 1].min()
    swung = max(SE2.from_array(each).apply(LONG.points)[:, 1].max() for each in poses)
    assert swung < wall + 0.002
    assert leaves(poses, costmap, LONG)


def test_the_escape_drives_off_past_the_cells_that_a_circle_touches() -> None:
    costmap, escape = beside(0.01), Escape(EscapeConfig(), TrackerConfig(), CIRCLE, LONG)
    assert escape.leave_contact(SE2(), costmap, -1.0)
    command = escape.compute(SE2(), STILL, np.zeros((1, 3)), costmap, 0.0)
    assert command is not None
    assert abs(command.x) > 0.1


def test_a_robot_before_a_wall_backs_off_before_its_corners_turn_into_it() -> None:
    costmap, pose = beside(0.05, radius=0.2), SE2(0.0, 0.0, 0.5 * math.pi)
    assert not collides(costmap, CIRCLE, pose)
    for body, backs in ((Footprint.circle(0.23), False), (LONG, True)):
        follower = PathFollower(load(FollowerConfig, {}), CIRCLE, body=body)
        follower.start(polyline([(0.0, 0.0), (0.0, -1.5)], 0.0), 0.0)
        command = follower.tick(pose, STILL, costmap, 0.0).velocity
        assert (command.x < 0.0) is backs, command


def test_a_turn_that_goes_round_and_round_is_looked_at_once() -> None:
    assert turn_touches(SE2(), 1e9, beside(0.005), LONG)


@pytest.mark.parametrize("slip", np.linspace(0.0, 0.05, 6))
def test_a_corner_slips_through_no_wall_between_its_points(slip: float) -> None:
    """They are one a cell: a corner 8 mm deep in the wall met none of them."""
    body = Footprint.polygon(np.array([[0.2, 0.15], [-0.2, 0.15], [-0.2, -0.15], [0.2, -0.15]]))
    poses = np.array([[slip, 0.0, 0.0], [slip, 0.0, 0.2]])
    corner = float(SE2.from_array(poses[-1]).apply(body.points)[:, 1].max())
    for depth, is_free in ((0.008, False), (-0.002, True)):
        costmap = beside(corner - depth - 0.19)
        assert leaves(poses, costmap, body, 0.0) is is_free
