"""A manoeuvre, command by command: how it drives ahead, back and round, and when it lets go."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.manoeuvre.manoeuvre import Manoeuvre, ManoeuvreConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

CORNERS = np.array([[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]])
LONG = Footprint.polygon(CORNERS)
CONFIG = ManoeuvreConfig()
AT = SE2(2.0, 1.5)
AHEAD = polyline([(2.0, 1.5), (5.0, 1.5)], 0.0)


def made_costmap(*blocks: tuple[float, float, float, float]) -> Costmap:
    grid = empty_grid(6.0, 3.0)
    for one in blocks:
        block(grid, *one)
    return costmap_of(grid, footprint=str(CORNERS.tolist()))


FREE = made_costmap()
CORRIDOR = made_costmap((0.0, 0.0, 6.0, 1.25), (0.0, 1.75, 6.0, 1.25))
"""Along x, too narrow to turn in."""


def begun_to(target: SE2, costmap: Costmap, config: ManoeuvreConfig = CONFIG) -> Manoeuvre:
    manoeuvre = Manoeuvre(config, LONG)
    assert manoeuvre.begin_to(AT, target, costmap)
    return manoeuvre


def driven(manoeuvre: Manoeuvre, costmap: Costmap) -> list[tuple[SE2, Velocity]]:
    """Return the poses and commands of a robot that drives exactly as told."""
    pose = AT
    told: list[tuple[SE2, Velocity]] = []
    for _ in range(1500):
        command = manoeuvre.compute(pose, costmap)
        if command is None:
            return [*told, (pose, Velocity())]
        told.append((pose, command))
        pose = pose @ SE2.exp((0.02 * command.x, 0.0, 0.02 * command.yaw_rate))
    raise AssertionError("it does not end")


@pytest.mark.parametrize(("speed", "deceleration"), [(0.3, 0.5), (0.2, 0.1)])
def test_it_backs_as_fast_as_it_can_brake_to_its_end(speed: float, deceleration: float) -> None:
    config = replace(CONFIG, max_speed=speed, deceleration=deceleration)
    told = driven(begun_to(SE2(1.2, 1.5), CORRIDOR, config), CORRIDOR)
    speeds = [-command.x for _, command in told[:-1]]
    assert speeds[0] == speed
    assert max(abs(command.yaw_rate) for _, command in told) < 1e-6
    braked = [(pose.x, v) for (pose, _), v in zip(told, speeds, strict=False) if v < speed]
    assert len(braked) > 3
    ends = [x - (v - 0.03) ** 2 / (2.0 * deceleration) for x, v in braked]
    assert ends == pytest.approx([ends[0]] * len(ends)), "each is the speed for what is left"
    assert 1.1 <= ends[0] <= 1.3
    assert 0.0 <= told[-1][0].x - ends[0] <= 0.015


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("rate", "deceleration"), [(1.0, 1.5), (0.7, 0.4)])
def test_it_turns_as_fast_as_it_can_brake_to_its_end(
    side: float, rate: float, deceleration: float
) -> None:
    config = replace(CONFIG, max_angular_velocity=rate, angular_deceleration=deceleration)
    told = driven(begun_to(AT @ SE2(0.0, 0.0, 1.6 * side), FREE, config), FREE)
    rates = [side * command.yaw_rate for _, command in told[:-1]]
    assert all(command.x == 0.0 for _, command in told)
    assert rates[0] == rate
    assert min(rates) >= 0.25, "what skidding wheels still do evenly"
    braked = [
        (side * pose.theta, w) for (pose, _), w in zip(told, rates, strict=False) if 0.25 < w < rate
    ]
    ends = [theta + w**2 / (2.0 * deceleration) for theta, w in braked]
    assert ends == pytest.approx([ends[0]] * len(ends))
    assert abs(ends[0] - 1.6) <= 0.26
    assert 0.0 <= ends[0] - side * told[-1][0].theta <= 0.05


@pytest.mark.parametrize("aside", [0.0, 0.03, -0.05])
def test_ahead_it_aims_at_a_point_of_the_way_a_little_on(aside: float) -> None:
    manoeuvre, pose = begun_to(SE2(3.0, 1.5), FREE), SE2(2.2, 1.5 + aside)
    command = manoeuvre.compute(pose, FREE)
    assert command is not None
    assert command.x == 0.3, "no braking: the controller takes over without a stop"
    way = 2.0 + 0.075 * np.arange(15)  # strides of one and a half cells
    here = int(np.abs(way - 2.2).argmin())
    seen = next(x - 2.2 for x in way[here:] if math.hypot(x - 2.2, aside) >= 0.2)
    bend = -2.0 * aside / (seen**2 + aside**2)
    assert command.yaw_rate == pytest.approx(0.3 * bend, abs=1e-6)


def test_it_keeps_the_bend_where_its_yaw_rate_is_limited() -> None:
    wide, narrow = (
        begun_to(SE2(3.0, 1.5), FREE, replace(CONFIG, max_angular_velocity=rate)).compute(
            SE2(2.2, 1.44, -0.2), FREE
        )
        for rate in (9.0, 0.5)
    )
    assert wide is not None
    assert narrow is not None
    assert narrow.yaw_rate == pytest.approx(0.5)
    assert narrow.yaw_rate / narrow.x == pytest.approx(wide.yaw_rate / wide.x)


def test_a_controller_may_go_on_where_only_driving_ahead_is_left_and_some_is_done() -> None:
    ahead, back = begun_to(SE2(3.0, 1.5), FREE), begun_to(SE2(1.2, 1.5), CORRIDOR)
    assert not ahead.may_end(SE2(2.29, 1.5), AHEAD, FREE)
    assert ahead.may_end(SE2(2.31, 1.5), AHEAD, FREE)
    assert not back.may_end(SE2(1.6, 1.5), AHEAD, CORRIDOR), "it backs"
    for x, free in ((3.0, False), (4.2, True)):  # a metre of the path has to be free
        blocked = made_costmap((x, 1.2, 0.1, 0.6))
        assert ahead.may_end(SE2(2.31, 1.5), AHEAD, blocked) is free


@pytest.mark.parametrize(("aside", "near"), [(0.45, True), (0.65, False)])
def test_it_leads_to_a_path_near_its_end(aside: float, near: bool) -> None:
    path = polyline([(0.5, 1.5 + aside), (3.1, 1.5 + aside)], 0.0)
    assert begun_to(SE2(3.0, 1.5), FREE).leads_to(path) is near


def test_it_lets_go_where_something_comes_into_its_way_and_where_it_is_not_wanted() -> None:
    manoeuvre = Manoeuvre(CONFIG, LONG)
    assert manoeuvre.begin(AT, AHEAD, FREE)
    assert manoeuvre.active
    assert manoeuvre.compute(AT, made_costmap((2.5, 1.2, 0.1, 0.6))) == Velocity(0.3)
    assert manoeuvre.compute(AT, made_costmap((2.4, 1.2, 0.1, 0.6))) is None  # 0.15 m are looked at
    assert not manoeuvre.active
    assert not Manoeuvre(replace(CONFIG, enabled=False), LONG).begin(AT, AHEAD, FREE)
    walled = made_costmap((2.5, 0.0, 0.1, 3.0))
    assert not manoeuvre.begin(AT, AHEAD, walled)
    assert not manoeuvre.begin_to(AT, SE2(4.0, 1.5), walled)


def test_it_leads_beyond_what_is_in_the_way_and_no_farther_than_it_reaches() -> None:
    box = made_costmap((2.4, 1.35, 0.2, 0.3))
    told = driven_to_the_end(box, CONFIG)
    assert 2.9 < told.x < 4.6
    near = replace(CONFIG, reach=0.8)
    assert not Manoeuvre(near, LONG).begin(AT, AHEAD, box), "all within its reach is blocked"
    for least, most in ((0.5, 0.8), (1.5, 1.7)):
        bounded = replace(CONFIG, rejoin_distance=least, reach=most)
        gone = driven_to_the_end(FREE, bounded).x - AT.x
        assert least - 0.12 < gone < most + 0.1


def driven_to_the_end(costmap: Costmap, config: ManoeuvreConfig) -> SE2:
    manoeuvre = Manoeuvre(config, LONG)
    assert manoeuvre.begin(AT, AHEAD, costmap)
    return driven(manoeuvre, costmap)[-1][0]
