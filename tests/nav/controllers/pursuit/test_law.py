"""Regulated pure pursuit, command by command, against its formulas."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import ControlResult, ControlStatus
from arjuna_nav.controllers.pursuit.config import RegulatedPurePursuitConfig
from arjuna_nav.controllers.pursuit.controller import RegulatedPurePursuit
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import clearances

RADIUS, TOLERANCE = 0.25, 0.2
LOOSE = RegulatedPurePursuitConfig(
    desired_linear_vel=0.5,
    lookahead_dist=0.6,
    rotate_to_heading_min_angle=0.8,
    rotate_to_heading_angular_vel=1.0,
    max_angular_accel=20.0,
    regulated_linear_scaling_min_speed=0.1,
    max_robot_pose_search_dist=9.0,
)
X_AXIS = np.column_stack((np.arange(0.0, 5.01, 0.1), np.zeros((51, 2))))
"""A path of 5 m."""


def flat(cost: int = 0, clearance: float = math.inf) -> Costmap:
    """Return a costmap with one cost, and the room that it stands for, everywhere."""
    frame = GridFrame(0.05, 200, 80, SE2(-2.0, -2.0))
    data = np.full(frame.shape, cost, np.uint8)
    return Costmap(frame, data, clearances=np.full(256, clearance))


class Asked:
    """A controller on the way along the x axis."""

    def __init__(self, limit: float = math.inf, **changes: Any) -> None:
        config = replace(LOOSE, **changes)
        self.controller = RegulatedPurePursuit(config, Footprint.circle(RADIUS), TOLERANCE, 0.05)
        self.controller.speed_limit = limit
        self.controller.set_path(X_AXIS)

    def __call__(self, pose: SE2, v: float = 0.0, costmap: Costmap | None = None) -> ControlResult:
        return self.controller.compute(pose, Velocity(v), costmap or flat(), 0.0)

    @property
    def aim(self) -> tuple[float, float]:
        carrot = self.controller.carrot
        assert carrot is not None
        return carrot.x, carrot.y


def arc(pose: SE2, lookahead: float = 0.6) -> tuple[float, float, float]:
    """Return the point of the x axis a lookahead away, seen from a pose, and its arc's bend."""
    point = SE2(pose.x + math.sqrt(lookahead**2 - pose.y**2), 0.0)
    seen = pose.inverse() @ point
    return seen.x, seen.y, 2.0 * seen.y / lookahead**2


@pytest.mark.parametrize("seed", range(6))
def test_drives_the_arc_through_the_point_a_lookahead_away(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = SE2(rng.uniform(1.0, 3.0), rng.uniform(-0.3, 0.3), rng.uniform(-0.25, 0.25))
    limit = float(rng.choice([math.inf, 0.3, 0.08]))
    asked = Asked(limit)
    x, y, bend = arc(pose)
    v = min(0.5, limit, 0.5 / abs(bend) / 0.9)  # slower in bends of less than 0.9 m
    v = max(v, min(0.1, limit))
    driven = asked(pose).velocity
    assert asked.aim == pytest.approx((x, y))
    assert driven.x == pytest.approx(min(v, 1.0 / abs(bend)))
    assert driven.yaw_rate == pytest.approx(driven.x * bend)


def test_a_path_that_begins_farther_away_is_driven_to_where_it_begins() -> None:
    asked = Asked()
    asked(SE2(-1.0, 0.1, 0.0))
    assert asked.aim == pytest.approx((1.0, -0.1))


def test_its_yaw_rate_is_limited_by_driving_slower() -> None:
    pose = SE2(1.0, 0.3, 0.1)
    _, _, bend = arc(pose)
    fast = {"use_regulated_linear_velocity_scaling": False, "rotate_to_heading_angular_vel": 0.4}
    driven = Asked(**fast)(pose).velocity
    assert (driven.x, driven.yaw_rate) == pytest.approx((0.4 / abs(bend), -0.4))


@pytest.mark.parametrize(
    ("speed", "lookahead"), [(0.0, 0.4), (0.3, 0.45), (-0.3, 0.45), (0.5, 0.75), (2.0, 0.9)]
)
def test_the_lookahead_grows_with_the_speed(speed: float, lookahead: float) -> None:
    own = {"min_lookahead_dist": 0.4, "max_lookahead_dist": 0.9, "lookahead_time": 1.5}
    asked, pose = Asked(use_velocity_scaled_lookahead_dist=True, **own), SE2(1.0, 0.1, 0.0)
    asked(pose, speed)
    assert math.hypot(*asked.aim) == pytest.approx(lookahead)


@pytest.mark.parametrize(
    ("cost", "room"),
    [(0, math.inf), (1, math.inf), (126, 0.25 + math.log(2.0) / 3.0), (252, 0.25), (254, math.inf)],
)
def test_near_obstacles_costs_encode_the_distance(cost: int, room: float) -> None:
    speed = 0.5 * min(0.8 * room / 0.6, 1.0)
    assert Asked(cost_scaling_gain=0.8, use_collision_detection=False)(
        SE2(1.0), costmap=flat(cost)
    ).velocity.x == pytest.approx(speed)


def test_the_distance_is_the_costmaps_own_where_it_has_one() -> None:
    steep = replace(flat(126), clearances=clearances(40.0))  # not the 3.0 of the controller
    driven = Asked(use_collision_detection=False)(SE2(1.0), costmap=steep).velocity
    assert driven.x == pytest.approx(0.5 * (0.25 + math.log(2.0) / 40.0) / 0.6)


def test_obstacles_do_not_slow_down_where_that_is_switched_off_nor_beyond_the_costmap() -> None:
    off = {"use_collision_detection": False}
    asked = Asked(use_cost_regulated_linear_velocity_scaling=False, **off)
    assert asked(SE2(1.0), costmap=flat(252)).velocity.x == 0.5
    elsewhere = Costmap(GridFrame(0.05, 1, 1, SE2(9.0, 9.0)), np.full((1, 1), 252, np.uint8))
    assert Asked(**off)(SE2(1.0), costmap=elsewhere).velocity.x == 0.5
    assert Asked(**off)(SE2(1.0), costmap=flat(253)).velocity.x < 0.21


@pytest.mark.parametrize(("left", "speed"), [(0.7, 0.5), (0.6, 0.5), (0.3, 0.25), (0.21, 0.175)])
def test_slows_down_with_what_is_left_to_the_goal(left: float, speed: float) -> None:
    driven = Asked(min_approach_linear_velocity=0.05)(SE2(5.0 - left, 0.0)).velocity
    assert driven.x == pytest.approx(speed, abs=0.045)  # the path begins at its nearest pose
    assert Asked(min_approach_linear_velocity=0.2)(SE2(4.75)).velocity.x >= 0.2
    assert Asked(0.1, min_approach_linear_velocity=0.2)(SE2(4.75)).velocity.x <= 0.1


@pytest.mark.parametrize(
    ("bearing", "turns"), [(0.75, False), (0.85, True), (-0.75, False), (-0.85, True)]
)
def test_turns_where_the_point_lies_aside_until_half_of_that(bearing: float, turns: bool) -> None:
    asked = Asked(use_collision_detection=False)
    first = asked(SE2(1.0, 0.0, -bearing), costmap=flat(clearance=0.0)).velocity
    assert (first.x == 0.0) is turns
    assert math.copysign(1.0, first.yaw_rate) == math.copysign(1.0, bearing)
    half = math.copysign(0.45, bearing)
    second = asked(SE2(1.0, 0.0, -half), costmap=flat(clearance=0.0)).velocity
    assert (second.x == 0.0) is turns
    assert asked(SE2(1.0, 0.0, -0.35 / 0.45 * half)).velocity.x > 0.0
    assert asked(SE2(1.0, 0.0, -half)).velocity.x > 0.0, "the turn is over"
    never = Asked(use_rotate_to_heading=False)
    assert never(SE2(1.0, 0.0, -bearing)).velocity.x > 0.0


def test_a_turn_gets_on_as_the_room_and_the_bearing_allow() -> None:
    pose = SE2(1.0, 0.0, -1.2)
    for clearance, v in ((math.inf, 0.5 * math.cos(1.2)), (0.2, 0.1), (0.0, 0.0)):
        driven = Asked()(pose, costmap=flat(clearance=clearance)).velocity
        assert (driven.x, driven.yaw_rate) == pytest.approx((v, 1.0))
    assert Asked(0.2)(pose).velocity.x == pytest.approx(0.2 * math.cos(1.2))
    assert Asked()(SE2(1.0, 0.0, -2.0)).velocity.x == 0.0, "it would lead away"


def test_at_the_goal_only_the_heading_is_left_and_stays_so() -> None:
    asked = Asked(rotate_to_heading_gain=1.5)
    assert asked(SE2(4.79, 0.0, 0.1)).velocity.x > 0.0
    for pose in (SE2(4.81, 0.0, -0.4), SE2(4.7, 0.0, -0.4)):
        driven = asked(pose).velocity
        assert (driven.x, driven.yaw_rate) == pytest.approx((0.0, 0.6))
        assert asked.controller.carrot is None
    asked.controller.set_path(X_AXIS + np.array([0.0, 0.09, 0.0]))
    assert asked(SE2(4.7, 0.0, -0.4)).velocity.x == 0.0, "the goal is the same"
    asked.controller.set_path(X_AXIS[:-3])
    assert asked(SE2(4.2, 0.0, 0.1)).velocity.x > 0.0


def blocked_from(x: float) -> Costmap:
    costmap = flat()
    costmap.data[:, round((x + 2.0) / 0.05) :] = 254
    return costmap


def test_an_arc_is_looked_at_for_a_time() -> None:
    pose = SE2(1.02)
    asked = Asked(max_allowed_time_to_collision_up_to_carrot=1.0, lookahead_dist=2.0)
    assert asked(pose, costmap=blocked_from(1.55)).status is ControlStatus.SUCCEEDED
    result = asked(pose, costmap=blocked_from(1.5))
    assert result.status is ControlStatus.NO_VALID_CONTROL
    assert result.velocity == STILL
    assert result.message == "collision ahead at (1.52, 0.00)"
    blind = Asked(use_collision_detection=False)
    assert blind(pose, costmap=blocked_from(1.0)).velocity.x == 0.5


@pytest.mark.parametrize(
    ("blocked", "share"), [(1.65, 1.0), (1.6, 0.7), (1.4, 0.5), (1.3, 0.35), (1.2, None)]
)
def test_arcs_are_checked_and_shortened_to_be_free(blocked: float, share: float | None) -> None:
    asked = Asked(max_allowed_time_to_collision_up_to_carrot=9.0, lookahead_dist=0.6)
    result = asked(SE2(1.02), costmap=blocked_from(blocked))
    assert (result.status is ControlStatus.SUCCEEDED) is (share is not None)
    assert asked.aim == pytest.approx((0.6 * (share or 0.35), 0.0))


@pytest.mark.parametrize(("aside", "turns"), [(0.33, False), (0.37, True)])
def test_where_no_arc_is_free_it_turns_if_the_path_leads_aside(aside: float, turns: bool) -> None:
    result = Asked()(SE2(1.02, 0.0, -aside), costmap=blocked_from(1.05))
    assert (result.status is ControlStatus.SUCCEEDED) is turns
    assert result.velocity.x == 0.0
    assert (result.velocity.yaw_rate > 0.0) is turns
    never = Asked(use_rotate_to_heading=False)
    result = never(SE2(1.02, 0.0, -aside), costmap=blocked_from(1.05))
    assert result.status is ControlStatus.NO_VALID_CONTROL
