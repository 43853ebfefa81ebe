"""The curve into a goal, command by command, against the paper's law."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.arrival_curve import ArrivalCurve
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint

ROBOT = Footprint.circle(0.25)
RATE, MOST, LATENCY, SPEED = 1.0, 0.8, 0.1, 0.4
GOAL = SE2(3.0, 2.0, 0.3)


def costmap_with(room: float = math.inf, cost: int = 0) -> Costmap:
    """Return a costmap of one cost, which tells so much room beside the robot."""
    frame = GridFrame(0.05, 120, 80, SE2())
    clearances = np.full(256, math.inf)
    clearances[cost] = room
    return Costmap(frame, np.full(frame.shape, cost, np.uint8), clearances=clearances)


def curve() -> ArrivalCurve:
    return ArrivalCurve(ROBOT, RATE, MOST, LATENCY)


def felt(pose: SE2, velocity: Velocity) -> SE2:
    """Return where the robot is when it feels the command."""
    return pose @ SE2.exp((LATENCY * velocity.x, 0.0, LATENCY * velocity.yaw_rate))


def law(seen: SE2) -> Velocity:
    """Return Park and Kuipers' velocity to a pose, with both gains 1.5, bends no slower."""
    r, sight = math.hypot(seen.x, seen.y), math.atan2(seen.y, seen.x)
    theta, delta, k = wrap(seen.theta - sight), -sight, 1.5
    steer = k * (delta - math.atan(-k * theta))
    bend = -(steer + (1.0 + k / (1.0 + (k * theta) ** 2)) * math.sin(delta)) / r
    w = min(max(SPEED * bend, -0.7 * RATE), 0.7 * RATE)  # by more, wheels drift
    return Velocity(min(SPEED, abs(w / bend)), yaw_rate=w)


@pytest.mark.parametrize(
    ("heading", "ends_at"),
    [(0.3, 0.3), (-0.5, -0.5), (0.79, 0.79), (1.5, 0.8), (-2.0, -0.8)],  # no more than 0.8 rad
)
def test_it_steers_to_the_goals_heading_or_to_a_part_of_the_turn(
    heading: float, ends_at: float
) -> None:
    start, moving = SE2(1.5, 2.0, 0.1), Velocity(0.3, yaw_rate=0.2)
    goal = SE2(3.0, felt(start, moving).y, heading)  # it lies along x from where it is felt
    found = curve().compute(start, goal, moving, costmap_with(), SPEED)
    assert found is not None
    expected = law(felt(start, moving).inverse() @ SE2(goal.x, goal.y, ends_at))
    assert (found.x, found.yaw_rate) == pytest.approx((expected.x, expected.yaw_rate))


def test_it_keeps_to_its_end_until_it_is_reset() -> None:
    steered, start, later = curve(), SE2(1.5, 2.0), SE2(2.0, 1.7)
    assert not steered.active
    steered.compute(start, SE2(3.0, 2.0, 1.5), STILL, costmap_with(), SPEED)
    assert steered.active
    found = steered.compute(later, SE2(3.0, 2.0, 1.5), STILL, costmap_with(), SPEED)
    expected = law(later.inverse() @ SE2(3.0, 2.0, 0.8))
    assert found is not None
    assert (found.x, found.yaw_rate) == pytest.approx((expected.x, expected.yaw_rate))
    steered.reset()
    assert not steered.active


@pytest.mark.parametrize(
    ("room", "cost", "free"),
    [(0.051, 100, True), (0.049, 100, False), (0.0, 0, False)],
)
def test_it_needs_room_beside_it_all_along(room: float, cost: int, free: bool) -> None:
    steered = curve()
    found = steered.compute(SE2(1.5, 2.0), GOAL, STILL, costmap_with(room, cost), SPEED)
    assert (found is not None) is free
    assert steered.active is free


def test_what_stands_on_the_curve_or_a_costmap_that_ends_there_lets_it_go() -> None:
    costmap = costmap_with()
    costmap.data[35:45, 45:47] = 254
    assert curve().compute(SE2(1.5, 2.0), GOAL, STILL, costmap, SPEED) is None
    beyond = SE2(6.5, 2.0, 0.0)
    assert curve().compute(SE2(5.0, 2.0), beyond, STILL, costmap_with(), SPEED) is None


@pytest.mark.parametrize("seed", range(8))
def test_on_its_last_bit_it_turns_half_to_the_place_and_half_to_the_heading(seed: int) -> None:
    rng, steered = np.random.default_rng(seed), curve()
    steered.compute(SE2(1.5, 2.0), SE2(3.0, 2.0, 0.3), STILL, costmap_with(), SPEED)
    pose = SE2(*rng.uniform((2.8, 1.95, 0.0), (2.97, 2.05, 0.5)))
    moving = Velocity(0.1, yaw_rate=float(rng.uniform(-0.5, 0.5)))
    seen = felt(pose, moving).inverse() @ SE2(3.0, 2.0, 0.3)
    distance = max(math.hypot(seen.x, seen.y), 0.02)
    bearing = math.atan2(seen.y, max(seen.x, 0.02))
    expected = 0.08 * (bearing + 0.5 * wrap(seen.theta)) / distance
    assert steered.last(pose, moving, 0.08) == pytest.approx(expected)
