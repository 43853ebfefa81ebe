"""The graceful controller, command by command, against Park and Kuipers' law."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import ControlResult, ControlStatus
from arjuna_nav.controllers.graceful.controller import Graceful, GracefulConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint

TOLERANCE, PERIOD = 0.2, 0.05
CONFIG = GracefulConfig(max_robot_pose_search_dist=9.0, max_angular_accel=2.0)
X_AXIS = np.column_stack((np.arange(0.0, 5.01, 0.1), np.zeros((51, 2))))
X_AXIS[-1, 2] = 1.0  # the goal's heading


def free(origin: SE2 = IDENTITY) -> Costmap:
    frame = GridFrame(0.05, 200, 80, origin @ SE2(-2.0, -2.0))
    return Costmap(frame, np.zeros(frame.shape, np.uint8))


class Asked:
    """A controller on the way along the x axis."""

    def __init__(self, limit: float = math.inf, **changes: Any) -> None:
        config = replace(CONFIG, **changes)
        self.controller = Graceful(config, Footprint.circle(0.25), TOLERANCE, PERIOD)
        self.controller.speed_limit = limit
        self.controller.set_path(X_AXIS)

    def __call__(self, pose: SE2, costmap: Costmap | None = None) -> ControlResult:
        return self.controller.compute(pose, STILL, costmap or free(), 0.0)

    @property
    def aim(self) -> SE2:
        assert self.controller.carrot is not None
        return self.controller.carrot


def law(seen: SE2, v_max: float, v_min: float = 0.1) -> Velocity:
    """Return the velocity of the paper's equations 5 to 15 to a pose seen from the robot."""
    r, sight = math.hypot(seen.x, seen.y), math.atan2(seen.y, seen.x)
    theta, delta, k1, k2 = wrap(seen.theta - sight), -sight, 2.0, 1.0
    inner = k2 * (delta - math.atan(-k1 * theta))
    bend = -(inner + (1.0 + k1 / (1.0 + (k1 * theta) ** 2)) * math.sin(delta)) / r
    v = min(v_max / (1.0 + 0.4 * abs(bend) ** 2), v_max * r / 1.5)
    v = min(max(v, v_min), v_max)
    w = min(max(v * bend, -1.0), 1.0)
    return Velocity(v if abs(bend) < 1e-6 else min(v, abs(w / bend)), yaw_rate=w)


@pytest.mark.parametrize("seed", range(8))
def test_steers_by_the_law_to_the_farthest_pose_within_the_lookahead(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = SE2(rng.uniform(0.5, 2.4), rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4))
    limit = float(rng.choice([math.inf, 0.3, 0.05]))
    asked = Asked(limit, initial_rotation=False)
    driven = asked(pose).velocity
    reached = math.floor(10.0 * (pose.x + math.sqrt(1.0 - pose.y**2)) + 1e-9) / 10.0
    seen = pose.inverse() @ SE2(reached)
    v_max = min(0.5, 1.5 * limit)  # of which two thirds are driven
    expected = law(seen, v_max, min(0.1, v_max))
    expected = expected.scaled(min(limit / expected.x, 1.0))
    assert (asked.aim.x, asked.aim.y) == pytest.approx((seen.x, seen.y))
    assert driven.x == pytest.approx(expected.x)
    assert driven.yaw_rate == pytest.approx(expected.yaw_rate)


@pytest.mark.parametrize(
    ("left", "speed"), [(1.55, 0.95 / 3.0), (0.9, 0.3), (0.3, 0.1), (0.21, 0.1)]
)
def test_slows_down_by_the_distance_of_the_pose_aimed_at(left: float, speed: float) -> None:
    assert Asked()(SE2(5.0 - left)).velocity.x == pytest.approx(speed)
    assert Asked(0.05)(SE2(5.0 - left)).velocity.x == pytest.approx(0.05)


@pytest.mark.parametrize(("radius", "speed"), [(1.5, 1.0 / 3.0), (1.0, 0.5), (0.3, 0.5)])
def test_the_final_approach_is_as_fast_as_the_way_there(radius: float, speed: float) -> None:
    controller = Asked(slowdown_radius=radius).controller
    assert controller.desired_speed == pytest.approx(speed)
    reached = Asked(slowdown_radius=radius)(SE2(1.0001)).velocity.x
    assert reached == pytest.approx(speed, abs=0.05)


@pytest.mark.parametrize(("straight", "bend"), [(True, 0.0), (False, -1.0)])
def test_comes_straight_to_the_goal_or_in_a_bow(straight: bool, bend: float) -> None:
    asked = Asked(prefer_final_rotation=straight)
    assert np.sign(asked(SE2(4.3)).velocity.yaw_rate) == bend
    assert asked.aim.array() == pytest.approx([0.7, 0.0, 1.0])
    assert asked(SE2(3.92)).velocity.yaw_rate == 0.0, "not the goal yet"
    assert asked.aim.x == pytest.approx(0.98)


def test_where_the_path_leaves_the_lookahead_its_first_pose_beyond_is_taken() -> None:
    asked = Asked(min_lookahead=0.25, max_lookahead=0.3, initial_rotation=False)
    asked(SE2(1.0, 0.5))
    assert (asked.aim.x, asked.aim.y) == pytest.approx((0.0, -0.5))
    asked = Asked(min_lookahead=0.45)
    asked(SE2(4.75))
    assert (asked.aim.x, asked.aim.y) == pytest.approx((0.25, 0.0)), "the goal, though near"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turns_towards_each_new_path_down_to_the_tolerance(side: float) -> None:
    def turned(asked: Asked, angle: float) -> bool:
        velocity = asked(SE2(1.0, 0.0, -side * angle)).velocity
        assert velocity.yaw_rate * side > 0.0
        return velocity.x == 0.0

    asked = Asked(initial_rotation_tolerance=0.75)
    assert [turned(asked, a) for a in (1.5, 0.76, 0.74, 1.5)] == [True, True, False, False]
    asked.controller.set_path(X_AXIS)
    assert turned(asked, 1.5)


@pytest.mark.parametrize("angle", [1.7, -2.5])
def test_without_that_turn_it_drives_round_in_a_bow(angle: float) -> None:
    """As one must that cannot turn on the spot."""
    asked, pose = Asked(initial_rotation=False), SE2(1.0, 0.0, angle)
    for _ in range(400):
        velocity = asked(pose).velocity
        assert velocity.x > 0.0
        pose = pose @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * PERIOD)
        if abs(pose.theta) < 0.1:
            break
    assert abs(pose.y) < 1.0
    assert abs(pose.theta) < 0.1


def test_a_turn_speeds_up_and_comes_to_rest() -> None:
    asked, pose = Asked(v_angular_min_in_place=0.25), SE2(1.0, 0.0, -2.0)
    rates = [asked(pose).velocity.yaw_rate for _ in range(12)]
    assert rates == pytest.approx([min(0.1 * k, 1.0) for k in range(1, 13)])
    slow = Asked(v_angular_min_in_place=0.25)
    assert [slow(SE2(4.9, 0.0, 0.9)).velocity.yaw_rate for _ in range(4)][-1] == pytest.approx(0.25)


@pytest.mark.parametrize(("scaling", "most", "rate"), [(0.5, 2.0, 0.3), (1.0, 0.9, 0.27)])
def test_a_turn_slows_down_by_the_angle_left(scaling: float, most: float, rate: float) -> None:
    asked = Asked(rotation_scaling_factor=scaling, v_angular_max=most)
    rates = [asked(SE2(5.0, 0.0, 0.7)).velocity.yaw_rate for _ in range(9)]
    assert rates[-1] == pytest.approx(rate)


@pytest.mark.parametrize(("gap", "arrived"), [(0.19, True), (0.21, False)])
def test_at_the_goal_it_turns_alone_until_it_is_pushed_away(gap: float, arrived: bool) -> None:
    asked = Asked()
    velocity = asked(SE2(5.0 - gap)).velocity
    assert (velocity.x == 0.0) is arrived
    assert (velocity.yaw_rate == pytest.approx(0.1)) is arrived
    assert (asked.controller.carrot is None) is arrived
    assert (asked(SE2(4.71)).velocity.x == 0.0) is arrived
    assert asked(SE2(4.6)).velocity.x > 0.0


@pytest.mark.parametrize("origin", [IDENTITY, SE2(4.0, -3.0, 2.2)])
def test_a_nearer_pose_is_steered_to_where_the_farther_is_not_reached(origin: SE2) -> None:
    asked, pose, costmap = Asked(), origin @ SE2(1.01), free(origin)
    path = np.column_stack((origin.apply(X_AXIS[:, :2]), X_AXIS[:, 2] + origin.theta))
    asked.controller.set_path(path)
    costmap.data[:, 75:] = 254  # from 1.75 m on
    assert asked(pose, costmap).status is ControlStatus.SUCCEEDED
    assert asked.aim.x == pytest.approx(0.69)
    costmap.data[:, 64:] = 254
    result = asked(pose, costmap)
    assert result.status is ControlStatus.NO_VALID_CONTROL
    assert result.velocity == STILL
    where = f"({pose.x:.2f}, {pose.y:.2f})"
    assert result.message == f"collision ahead on every approach to the path from {where}"


def test_the_goal_is_come_to_in_the_direction_from_the_robot() -> None:
    asked, bent = Asked(), X_AXIS.copy()
    bent[-1] = 5.0, 0.1, -1.0
    asked.controller.set_path(bent)
    velocity, seen = asked(SE2(4.3)).velocity, SE2(0.7, 0.1, math.atan2(0.1, 0.7))
    expected = law(seen, 0.5)
    assert (velocity.x, velocity.yaw_rate) == pytest.approx((expected.x, expected.yaw_rate))


def test_a_turn_that_would_collide_is_refused() -> None:
    box = Footprint.polygon(np.array([[0.5, 0.1], [0.5, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
    controller, costmap = Graceful(CONFIG, box, TOLERANCE, 9.0), free()
    costmap.data[costmap.frame.to_cell(1.45, -0.02)] = 254
    controller.set_path(X_AXIS)
    result = controller.compute(SE2(1.0, 0.0, 1.0), STILL, costmap, 0.0)
    assert result.status is ControlStatus.NO_VALID_CONTROL
    assert result.message == "turning at (1.00, 0.00) would collide"


@pytest.mark.parametrize("x", [0.0, 3.5, 4.5])
@pytest.mark.parametrize("seed", range(3))
def test_backward_it_drives_as_the_robot_turned_round_drives_forward(x: float, seed: int) -> None:
    y, yaw = np.random.default_rng(seed).uniform(-0.3, 0.3, 2)
    pose, turned = SE2(x, y, yaw), SE2(theta=math.pi)
    forward, back = Asked(initial_rotation=False), Asked(initial_rotation=False)
    back.controller = Graceful(
        replace(CONFIG, initial_rotation=False, allow_backward=True),
        Footprint.circle(0.25),
        TOLERANCE,
        PERIOD,
    )
    back.controller.set_path(X_AXIS + np.array([0.0, 0.0, math.pi]))
    ahead, behind = forward(pose), back(pose @ turned)
    assert behind.velocity.x == pytest.approx(-ahead.velocity.x)
    assert behind.velocity.yaw_rate == pytest.approx(ahead.velocity.yaw_rate)
    assert ahead.velocity.x > 0.0
    assert back.aim.x == pytest.approx(-forward.aim.x)


def test_it_turns_round_first_or_drives_backward() -> None:
    with pytest.raises(ConfigError, match="valid: one of them at most"):
        replace(CONFIG, allow_backward=True)
