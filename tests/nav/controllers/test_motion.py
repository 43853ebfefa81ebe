"""Arcs, braking, turns on the spot, and a path that is being followed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import PathError, TrackedPath
from arjuna_nav.controllers.motion import (
    Turning,
    braking_speed,
    crossing,
    curvature_into,
    curvature_to,
    rollout,
)
from arjuna_nav.planners import path as paths

START = SE2(1.0, -2.0, 0.6)


@pytest.mark.parametrize(
    ("velocity", "steps"),
    [
        (Velocity(0.5), 20),  # by 5 cm
        (Velocity(-0.31), 13),
        (Velocity(0.4, yaw_rate=0.7), 16),
        (Velocity(0.3, yaw_rate=-1.9), 38),  # by 0.1 rad
        (Velocity(yaw_rate=1.21), 25),
        (Velocity(y=-0.5), 20),
        (Velocity(0.3, y=0.4, yaw_rate=0.7), 20),
        (Velocity(), 0),
    ],
)
def test_an_arc_is_the_exponential_of_its_twist(velocity: Velocity, steps: int) -> None:
    poses = rollout(START, velocity, 2.0, 0.05)
    assert len(poses) == 1 + steps
    for pose, time in zip(poses, np.linspace(0.0, 2.0, 1 + steps), strict=True):
        expected = START @ SE2.exp(np.array([velocity.x, velocity.y, velocity.yaw_rate]) * time)
        assert pose[:2] == pytest.approx([expected.x, expected.y])
        assert pose[2] == pytest.approx(START.theta + velocity.yaw_rate * time), "it is not wrapped"


def test_an_arc_goes_round_once_and_has_no_more_poses_than_can_be_looked_at() -> None:
    round_once = rollout(START, Velocity(0.5, yaw_rate=-2.0), 60.0, 0.05)
    assert round_once[-1] == pytest.approx([1.0, -2.0, 0.6 - 2.0 * math.pi])
    assert len(round_once) == 1 + 63
    assert len(rollout(START, Velocity(1e6), 60.0, 0.05)) == 10_001


@pytest.mark.parametrize("seed", range(4))
def test_a_segment_leaves_a_circle_where_it_is_a_radius_away(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose, inside, outside = (SE2(*rng.uniform(-1.0, 1.0, 2)) for _ in range(3))
    near, far = sorted((inside, outside), key=pose.distance)
    radius = float(rng.uniform(pose.distance(near), pose.distance(far)))
    share = crossing(pose, near, far, radius)
    assert 0.0 < share < 1.0
    assert pose.distance(near.interpolate(far, share)) == pytest.approx(radius)


@pytest.mark.parametrize(
    ("before", "after", "share"),
    [
        (SE2(0.1), SE2(0.5), 1.0),  # within all along
        (SE2(1.5), SE2(2.5), 0.0),  # outside all along
        (SE2(-3.0), SE2(1.0), 1.0),  # in and to its edge: not where it enters
        (SE2(-1.0, 2.0), SE2(3.0, 2.0), 0.25),  # past it: where it is nearest
        (SE2(0.2), SE2(0.2), 1.0),  # no segment
    ],
)
def test_inside_the_circle_the_share_is_kept(before: SE2, after: SE2, share: float) -> None:
    assert crossing(SE2(), before, after, 1.0) == pytest.approx(share)


@pytest.mark.parametrize(
    ("angle", "last", "rate"),
    [
        (3.0, 1.0, 1.0),  # as fast as it may
        (0.4, 0.6, 0.6),  # by the gain
        (0.06, 0.2, 0.2),  # what the wheels still do
        (0.05, 0.075, 0.075),  # settled: the gain again
        (0.0, 0.0, 0.0),
        (3.0, 0.0, 0.2),  # one period's change
        (3.0, -1.0, -0.8),
        (0.2, 1.0, 0.8),
    ],
)
def test_a_turn_is_within_each_of_its_limits(angle: float, last: float, rate: float) -> None:
    turning = Turning(1.0, 2.0, 0.1, gain=1.5, rate_min=0.2, settled=0.05)
    assert turning.towards(angle, last) == pytest.approx(rate)
    assert turning.towards(-angle, -last) == pytest.approx(-rate)


def test_a_turn_brakes_in_time_and_its_least_rate_is_no_more_than_its_greatest() -> None:
    assert Turning(1.0, 0.3, 0.1).towards(0.4, 0.34) == pytest.approx(math.sqrt(0.3 * 0.4))
    assert Turning(0.15, 2.0, 0.1, rate_min=0.2).towards(0.06, 0.15) == pytest.approx(0.15)
    assert Turning(0.08, 2.0, 0.1, rate_min=0.2).towards(0.06, 0.0) == pytest.approx(0.08)


@pytest.mark.parametrize(
    ("distance", "deceleration", "final", "speed"),
    [(1.0, 0.5, 0.0, 1.0), (0.5, 0.8, 0.3, 0.943398), (0.0, 2.0, 0.4, 0.4), (-1.0, 2.0, 0.4, 0.4)],
)
def test_who_brakes_from_the_braking_speed_has_the_final_speed_after_the_distance(
    distance: float, deceleration: float, final: float, speed: float
) -> None:
    assert braking_speed(distance, deceleration, final) == pytest.approx(speed)


@pytest.mark.parametrize("seed", range(5))
def test_an_arc_of_the_curvature_to_a_point_leads_through_it(seed: int) -> None:
    x, y = np.random.default_rng(seed).uniform((0.2, -1.0), (1.0, 1.0))
    curvature = curvature_to(x, y)
    angle = 2.0 * math.atan2(y, x)
    end = SE2.exp((angle / curvature, 0.0, angle))
    assert (end.x, end.y) == pytest.approx((x, y))
    assert curvature_to(1.0, 0.0) == 0.0


def straight(length: float, y: float = 0.0) -> np.ndarray:
    xs = np.arange(0.0, length + 0.05, 0.1)
    return np.column_stack((xs, np.full(len(xs), y), np.zeros(len(xs))))


def test_a_tracked_path_begins_where_the_robot_is_and_never_goes_back() -> None:
    path = TrackedPath(search=1.05)
    path.replace(straight(3.0))
    assert path.goal == SE2(3.0)
    assert path.length == pytest.approx(3.0)
    for x, begins in ((0.52, 0.5), (0.2, 0.5), (1.4, 1.4), (9.0, 2.4)):  # no further than 1 m on
        path.advance(SE2(x, 0.3))
        assert path.ahead[0, 0] == pytest.approx(begins)
    assert path.length == pytest.approx(0.6)
    assert not path.replace(straight(3.0))
    assert path.ahead[0, 0] == 0.0


def test_a_goal_within_a_tenth_of_a_metre_is_the_same() -> None:
    path = TrackedPath(search=1.0)
    assert path.replace(straight(3.0)), "the first is new"
    assert not path.replace(straight(3.0, y=0.1))
    assert path.replace(straight(3.0, y=0.21))
    assert path.replace(straight(2.8, y=0.21))
    for shape in ((0, 3), (4, 2), (3,)):
        with pytest.raises(PathError, match=r"must be \(N, 3\) with N > 0, got \(" + str(shape[0])):
            path.replace(np.zeros(shape))


@pytest.mark.parametrize(("distance", "poses"), [(0.0, 2), (0.05, 2), (0.25, 3), (99.0, 31)])
def test_the_first_part_has_two_poses_at_least(distance: float, poses: int) -> None:
    path = TrackedPath(search=1.0)
    path.replace(straight(3.0))
    assert len(path.within(distance)) == poses
    path.replace(straight(0.0))
    assert len(path.within(distance)) == 1


def cusped() -> np.ndarray:
    """Return a path 1 m forward, 0.5 m back with a turn on the spot between, and 0.8 m forward."""
    xs = np.concatenate((np.arange(0.0, 1.01, 0.1), [1.0], np.arange(0.9, 0.49, -0.1)))
    return np.column_stack((np.append(xs, np.arange(0.6, 1.31, 0.1)), np.zeros(25), np.zeros(25)))


def test_a_path_is_reached_in_one_direction_up_to_where_it_inverts() -> None:
    path = cusped()
    first = paths.part_end(path)
    assert path[first - 1, 0] == pytest.approx(1.0)
    second = paths.part_end(path, first - 1)
    assert path[second - 1, 0] == pytest.approx(0.5)
    assert paths.part_end(path, second - 1) == len(path) == paths.part_end(path[:2]) + 23


@pytest.mark.parametrize(
    ("tolerance", "pose", "begins"),
    [
        (None, SE2(0.94), False),
        (None, SE2(0.96, 0.3, 2.0), True),
        ((0.2, 0.4), SE2(0.85, 0.0, 0.3), True),
        ((0.2, 0.4), SE2(0.85, 0.0, 0.5), False),
        ((0.2, 0.4), SE2(1.0, 0.3), False),
    ],
)
def test_the_next_part_begins_at_the_end_of_the_last(
    tolerance: tuple[float, float] | None, pose: SE2, begins: bool
) -> None:
    path = TrackedPath(search=-1.0, inverts=True, inversion_tolerance=tolerance)
    path.replace(cusped())
    path.advance(pose)
    assert path.part[-1, 0] == pytest.approx(0.5 if begins else 1.0)
    assert path.ahead[-1, 0] == pytest.approx(1.3)
    assert path.within(9.0)[-1, 0] == path.part[-1, 0]


@pytest.mark.parametrize("bend", [2.0, -0.7, 0.0])
def test_the_curve_into_a_pose_is_an_arc_that_ends_with_its_heading(bend: float) -> None:
    seen = SE2.exp((0.3, 0.0, 0.3 * bend))
    assert curvature_into(seen) == pytest.approx(bend, abs=1e-9)
    assert curvature_into(SE2(seen.x, seen.y, seen.theta + 0.1)) < bend
    straight = SE2(0.2, 0.0, 0.1)  # of the cubic y = 0.1 x^2 (x - 0.2) / 0.04
    assert curvature_into(straight) == pytest.approx(-2.0 * 0.1 / 0.2, rel=0.01)
