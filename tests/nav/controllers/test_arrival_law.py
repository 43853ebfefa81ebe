"""The last stretch, command by command: when it begins, how it brakes, turns and ends."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.arrival import Arrival, ArrivalConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint

ROBOT = Footprint.circle(0.25)
GOAL = SE2(3.0, 2.0, 0.0)
STRAIGHT = ArrivalConfig(
    distance=0.5,
    xy_precision=0.01,
    yaw_precision=0.015,
    deceleration=0.5,
    max_angular_velocity=1.2,
    min_angular_velocity=0.1,
    angular_deceleration=1.5,
    latency=0.12,
    curve_time=0.0,
    patience=2.0,
)


def free() -> Costmap:
    frame = GridFrame(0.05, 120, 80, SE2())
    return Costmap(frame, np.zeros(frame.shape, np.uint8))


def before(distance: float, bearing: float = 0.0, heading: float = 0.0) -> SE2:
    """Return a pose so far from the goal, which it sees at a bearing."""
    sight = heading + bearing
    return SE2(3.0 - distance * math.cos(sight), 2.0 - distance * math.sin(sight), heading)


class Asked:
    """An arrival that is asked again and again."""

    def __init__(self, config: ArrivalConfig = STRAIGHT) -> None:
        self.arrival = Arrival(config, ROBOT)

    def __call__(
        self,
        pose: SE2,
        velocity: Velocity | None = None,
        now: float = 0.0,
        costmap: Costmap | None = None,
        **told: Any,
    ) -> Velocity | None:
        own = {"left": pose.distance(GOAL), "speed": 0.5, "within": False, "heading": True}
        given: dict[str, Any] = {**own, **told}
        costs = costmap or free()
        return self.arrival.compute(pose, GOAL, velocity or Velocity(), costs, now, **given)


@pytest.mark.parametrize(
    ("pose", "told", "begins"),
    [
        (before(0.499), {}, True),
        (before(0.501), {}, False),
        (before(1.19), {"velocity": Velocity(1.0)}, True),  # a fifth more than it brakes in
        (before(1.21), {"velocity": Velocity(1.0)}, False),
        (before(0.4, 0.34), {}, True),
        (before(0.4, 0.36), {}, False),
        (before(0.4, -0.36), {}, False),
        (before(0.4), {"left": 0.469}, True),  # the path leads there straight
        (before(0.4), {"left": 0.471}, False),
        (before(0.9, 2.0), {"within": True}, True),
    ],
)
def test_takes_over_where_the_rest_is_short_straight_and_ahead(
    pose: SE2, told: dict[str, Any], begins: bool
) -> None:
    assert (Asked()(pose, **told) is not None) is begins
    assert Asked(replace(STRAIGHT, enabled=False))(pose, **told) is None


@pytest.mark.parametrize("bearing", [0.0, 0.1, -0.2])
@pytest.mark.parametrize(("distance", "driving"), [(0.45, 0.0), (0.3, 0.4), (0.02, 0.1), (0.06, 0)])
def test_brakes_into_the_goal_from_where_the_command_is_felt(
    bearing: float, distance: float, driving: float
) -> None:
    command = Asked()(before(distance, bearing), Velocity(driving))
    assert command is not None
    way = max(distance * math.cos(bearing) - 0.12 * driving, 0.0)
    assert command.x == pytest.approx(min(0.5, max(math.sqrt(2.0 * 0.5 * way), 0.04)))
    steered = 2.0 * bearing * min(command.x / 0.2, 1.0) if distance > 0.05 else 0.0
    assert command.yaw_rate == pytest.approx(steered)


def test_it_is_no_faster_than_it_may_and_steers_no_more() -> None:
    asked = Asked(replace(STRAIGHT, max_angular_velocity=0.3))
    assert asked(before(0.4, 0.3), speed=0.2) == Velocity(0.2, yaw_rate=0.3)
    assert asked(before(0.4, -0.3), speed=0.2) == Velocity(0.2, yaw_rate=-0.3)
    assert asked(before(0.4, 0.1), speed=0.1) == Velocity(0.1, yaw_rate=pytest.approx(0.1))  # type: ignore[arg-type]


def test_what_went_past_the_goal_comes_straight_back() -> None:
    asked = Asked()
    assert asked(before(0.1)) is not None
    assert asked(SE2(3.02, 2.005, 0.0)) == Velocity(-0.04)
    assert asked(SE2(3.02, 2.005, 0.0), speed=0.03) == Velocity(-0.03)


def turned(angle: float, rate: float) -> float:
    """Return the yaw rate from which a turn comes to rest at an angle, given the one driven."""
    rest = angle - 0.12 * rate
    if rest * angle <= 0.0 or (rest * rate < 0.0 and abs(rate) > 0.1):
        return 0.0
    fast = min(math.sqrt(2.0 * 1.5 * abs(rest)), abs(rest) / 0.12, 1.2)
    return math.copysign(max(fast, 0.1), angle)


TURNS = [
    *((0.5, 0.0), (-0.5, 0.0), (3.0, 0.0), (0.1, 0.0), (0.02, 0.0), (0.1, 0.5)),
    *((0.1, 1.0), (-0.1, -1.0), (0.3, -0.4), (-0.3, 0.4), (0.3, -0.002), (-0.3, 0.09)),
]


@pytest.mark.parametrize(("angle", "rate"), TURNS)
def test_turns_to_the_goals_heading_once_it_is_there(angle: float, rate: float) -> None:
    command = Asked()(SE2(2.995, 2.003, -angle), Velocity(yaw_rate=rate), within=True)
    assert command is not None
    assert (command.x, command.yaw_rate) == pytest.approx((0.0, turned(angle, rate)))


def test_noise_of_a_robot_at_rest_holds_up_no_turn() -> None:
    for rate in (0.001, -0.001):
        command = Asked()(SE2(2.995, 2.003, -1.0), Velocity(yaw_rate=rate), within=True)
        assert command is not None
        assert command.yaw_rate == pytest.approx(1.2)


@pytest.mark.parametrize("distance", [0.051, 0.04, 0.02])
@pytest.mark.parametrize("off", [0.3, -2.0])
def test_the_last_turn_begins_while_the_robot_comes_to_rest(distance: float, off: float) -> None:
    for heading in (True, False):
        asked = Asked()
        assert asked(before(0.2, heading=-off), heading=heading) is not None
        command = asked(
            before(distance, heading=-off), Velocity(0.1, yaw_rate=0.1), heading=heading
        )
        assert command is not None
        assert command.x > 0.0
        begun = heading and distance < 0.05
        expected = (1.0 - distance / 0.05) * turned(off, 0.1) if begun else 0.0
        assert command.yaw_rate == pytest.approx(expected, abs=1e-9 if begun else 0.02)


@pytest.mark.parametrize(("bearing", "rate"), [(0.5, 0.0), (-2.0, 0.0), (1.0, 0.8), (3.0, -0.3)])
def test_turns_to_a_goal_that_lies_aside_and_then_drives(bearing: float, rate: float) -> None:
    asked = Asked()
    command = asked(before(0.15, bearing), Velocity(yaw_rate=rate), within=True)
    assert command is not None
    assert (command.x, command.yaw_rate) == pytest.approx((0.0, turned(bearing, rate)))
    still = asked(before(0.15, math.copysign(0.36, bearing)), now=0.1, within=True)
    assert still is not None
    assert still.x == 0.0
    driven = asked(before(0.15, math.copysign(0.34, bearing)), now=0.2, within=True)
    assert driven is not None
    assert driven.x > 0.0


@pytest.mark.parametrize(
    ("pose", "ends"),
    [
        (SE2(2.991, 2.0, 0.014), True),
        (SE2(2.989, 2.0, 0.014), False),
        (SE2(2.996, 2.1, 0.014), True),  # beside it: to turn and drive there gains nothing
        (SE2(2.994, 2.02, 0.014), False),
        (SE2(2.991, 2.0, 0.016), False),
        (SE2(2.991, 2.0, -0.016), False),
    ],
)
def test_has_arrived_where_place_and_heading_are_exact_enough(pose: SE2, ends: bool) -> None:
    asked = Asked()
    assert asked(before(0.1)) is not None
    assert (asked(pose) is None) is ends
    assert not ends or asked(before(0.1)) is None, "it lets go for good"
    asked.arrival.reset()
    assert asked(before(0.1)) is not None


@pytest.mark.parametrize(("rate", "ends"), [(0.2, True), (0.3, False), (-0.3, False)])
def test_a_turn_that_would_go_on_too_far_has_not_ended(rate: float, ends: bool) -> None:
    command = Asked()(SE2(2.995, 2.0, 0.0), Velocity(yaw_rate=rate), within=True)
    assert (command is None) is ends
    assert Asked()(SE2(2.995, 2.0, 1.0), within=True, heading=False) is None


def test_who_gets_no_nearer_for_too_long_lets_go() -> None:
    asked, stuck = Asked(), before(0.3)
    for now in (0.0, 1.9, 2.0):
        assert asked(stuck, now=now) is not None
    nearer = before(0.298)
    for now in (2.1, 4.0):
        assert asked(nearer, now=now) is not None
    assert asked(before(0.2975), now=4.2) is None, "by less than a millimetre does not count"
    assert asked(before(0.2), now=4.3) is None


CURVING = replace(STRAIGHT, curve_time=4.0)


@pytest.mark.parametrize(
    ("pose", "told", "curves"),
    [
        (before(1.9), {}, True),  # 4 s at 0.5 m/s
        (before(2.1), {}, False),
        (before(1.1), {"speed": 0.25}, False),
        (before(1.9), {"heading": False}, False),
        (before(1.5, 0.36), {}, False),
        (before(1.5), {"left": 1.64}, False),
        (before(1.5), {"left": 1.62}, True),
    ],
)
def test_a_curve_to_the_goals_heading_begins_sooner(
    pose: SE2, told: dict[str, Any], curves: bool
) -> None:
    assert (Asked(CURVING)(pose, **told) is not None) is curves
    assert Asked()(pose, **told) is None


@pytest.mark.parametrize(
    ("pose", "window", "free_all_along"),
    [
        (before(0.4), np.s_[:, 59:], False),  # 5 cm before the goal
        (before(0.4), np.s_[:, 61:], True),  # behind it
        (before(0.4), np.s_[42:, :], True),  # beside the way there
        (before(0.2, 1.0), np.s_[:, 59:], True),  # it only turns
    ],
)
def test_what_lies_on_the_rest_of_its_way_is_not_driven_into(
    pose: SE2, window: tuple[slice, slice], free_all_along: bool
) -> None:
    costmap = free()
    costmap.data[window] = 253
    assert (Asked()(pose, costmap=costmap, within=True) is not None) is free_all_along


@pytest.mark.parametrize(("angle", "free_all_along"), [(0.3, True), (0.9, False), (-0.9, True)])
def test_a_long_robot_does_not_turn_into_what_is_beside_it(
    angle: float, free_all_along: bool
) -> None:
    box = Footprint.polygon(np.array([[0.5, 0.1], [0.5, -0.1], [-0.2, -0.1], [-0.2, 0.1]]))
    arrival, costmap = Arrival(STRAIGHT, box), free()
    costmap.data[costmap.frame.to_cell(3.0 + 0.45 * math.cos(0.9), 2.0 + 0.45 * math.sin(0.9))] = (
        254
    )
    told: dict[str, Any] = {"left": 0.0, "speed": 0.5, "within": True, "heading": True}
    goal = SE2(3.0, 2.0, angle)
    driven = SE2(3.0, 2.0) @ SE2(-0.04, 0.0)
    told["within"] = False
    assert arrival.compute(driven @ SE2(-0.1, 0.0), goal, Velocity(), costmap, 0.0, **told)
    rolling = arrival.compute(driven, goal, Velocity(), costmap, 0.0, **told)
    assert rolling is not None  # what is free is driven, and no turn begun that is not
    assert rolling.x > 0.0
    assert (rolling.yaw_rate != 0.0) is free_all_along
    arrival.reset()
    told["within"] = True
    command = arrival.compute(SE2(3.0, 2.0), goal, Velocity(), costmap, 0.0, **told)
    assert (command is not None) is free_all_along
