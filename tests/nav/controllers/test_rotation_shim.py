"""The rotation shim, command by command: when it turns, how far, and what it leaves to whom."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import Controller, ControlResult, ControlStatus
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import W_MAX, XY_TOLERANCE, make

SHIMMED = "pure pursuit under the shim"
BOX = Footprint.polygon(np.array([[0.5, 0.1], [0.5, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
X_AXIS = np.column_stack((np.arange(0.0, 4.01, 0.1), np.zeros((41, 2))))
ALL_ROUND = X_AXIS + np.array([0.0, 0.0, 1.0]) * (X_AXIS[:, :1] == 4.0)
"""The x axis, and at its end a heading of 1 rad."""


def free() -> Costmap:
    frame = GridFrame(0.05, 160, 80, SE2(-2.0, -2.0))
    return Costmap(frame, np.zeros(frame.shape, np.uint8))


def shim(footprint: Footprint | None = None, **values: Any) -> Controller:
    own = {"angular_dist_threshold": 0.8, "angular_disengage_threshold": 0.4, **values}
    controller = make(SHIMMED, footprint, **own)
    controller.set_path(ALL_ROUND)
    return controller


def asked(controller: Controller, pose: SE2, w: float = 0.0) -> ControlResult:
    return controller.compute(pose, Velocity(yaw_rate=w), free(), 0.0)


def turns(controller: Controller, pose: SE2) -> bool:
    """Return whether it turns itself: then it aims at no point."""
    result = asked(controller, pose)
    assert result.status is ControlStatus.SUCCEEDED
    assert controller.carrot is not None or result.velocity.x == 0.0
    return controller.carrot is None


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_turn_begins_beyond_one_angle_and_ends_within_another(side: float) -> None:
    controller = shim()
    assert not turns(controller, SE2(0.0, 0.0, 0.79 * side))
    assert not turns(controller, SE2(0.0, 0.0, 0.81 * side)), "it is due no more"
    controller.set_path(ALL_ROUND)
    for angle, due in ((0.81, True), (0.41, True), (0.39, False), (0.9, False)):
        assert turns(controller, SE2(0.0, 0.0, angle * side)) is due
    controller.set_path(ALL_ROUND)
    assert turns(controller, SE2(0.0, 0.0, 0.9 * side)), "for each new path"


def test_its_yaw_rate_continues_from_the_one_measured() -> None:
    controller = shim()
    for w, expected in ((0.0, 0.075), (0.5, 0.575), (W_MAX, W_MAX)):
        command = asked(controller, SE2(0.0, 0.0, -2.0), w).velocity
        assert command.x == 0.0
        assert command.yaw_rate == pytest.approx(expected)


def test_a_turn_is_for_a_new_goal_only_if_that_is_asked_for() -> None:
    controller = shim(rotate_to_heading_once=True)
    assert turns(controller, SE2(0.0, 0.0, 2.0))
    assert not turns(controller, SE2(0.0, 0.0, 0.1))
    controller.set_path(ALL_ROUND)
    assert not turns(controller, SE2(0.0, 0.0, 2.0))
    controller.set_path(ALL_ROUND[:-5])
    assert turns(controller, SE2(0.0, 0.0, 2.0))


@pytest.mark.parametrize(
    ("x", "y", "far"), [(3.6, 0.0, False), (3.4, 0.0, True), (3.6, 0.31, True)]
)
def test_it_aims_ahead_and_leaves_the_rest_to_the_primary(x: float, y: float, far: bool) -> None:
    controller = shim(forward_sampling_distance=0.5)
    for at in (1.0, 2.0, 3.0):
        asked(controller, SE2(at))
    controller.set_path(ALL_ROUND[25:])
    assert turns(controller, SE2(x, y, 2.0)) is far


@pytest.mark.parametrize(("gap", "turned"), [(0.19, True), (0.21, False)])
def test_at_the_goal_it_turns_to_its_heading_where_asked(gap: float, turned: bool) -> None:
    assert 0.19 < XY_TOLERANCE < 0.21
    controller = make("mppi under the shim", rotate_to_goal_heading=True)  # it never only turns
    controller.set_path(ALL_ROUND[30:])
    command = asked(controller, SE2(4.0 - gap, 0.0, 0.9)).velocity
    assert (command.x == 0.0) is turned
    assert not turned or command.yaw_rate == pytest.approx(0.075)


@pytest.mark.parametrize(
    ("ahead", "aside", "hits"),
    [
        (0.3, 0.7, False),  # 0.24 rad are looked at, and the box is 0.2 rad wide to each side
        (1.0, 0.7, True),  # 0.8 rad
        (1.0, 1.15, False),
        (9.0, 1.15, True),  # a radian, and no more
        (9.0, 1.4, False),
    ],
)
def test_where_a_turn_would_collide_the_primary_drives(
    ahead: float, aside: float, hits: bool
) -> None:
    costmap, bearing = free(), -2.0 + aside
    cell = costmap.frame.to_cell(0.45 * math.cos(bearing), 0.45 * math.sin(bearing))
    costmap.data[cell] = 254
    controller, alone = shim(BOX, simulate_ahead_time=ahead), make("pure pursuit", BOX)
    alone.set_path(ALL_ROUND)
    at = SE2(0.0, 0.0, -2.0), Velocity(yaw_rate=W_MAX), costmap, 0.0
    result = controller.compute(*at)
    if hits:
        assert result == alone.compute(*at)
        assert controller.compute(SE2(), STILL, free(), 0.1).velocity.x > 0.0
    else:
        assert (result.velocity.x, result.velocity.yaw_rate) == (0.0, W_MAX)


def test_in_an_open_loop_a_turn_continues_from_the_last_command() -> None:
    for closed, rates in ((True, (0.075, 0.075)), (False, (0.075, 0.15))):
        controller = shim(closed_loop=closed, max_angular_accel=1.5)
        for rate in rates:
            assert asked(controller, SE2(0.0, 0.0, -1.5)).velocity.yaw_rate == pytest.approx(rate)


def test_it_may_turn_to_the_heading_of_the_paths_pose() -> None:
    aside = X_AXIS + np.array([0.0, 0.0, -1.2])
    for oriented, first in ((False, 0.0), (True, -0.075)):
        controller = shim(use_path_orientations=oriented, max_angular_accel=1.5)
        controller.set_path(aside)
        assert asked(controller, SE2()).velocity.yaw_rate == pytest.approx(first)
