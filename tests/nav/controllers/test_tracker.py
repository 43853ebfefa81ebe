"""A trajectory, command by command: how it is driven ahead, back and round, and where it ends."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.motion import curvature_into
from arjuna_nav.controllers.tracker import Tracker, TrackerConfig, pieces_of

CONFIG = TrackerConfig(
    deceleration=0.5,
    max_angular_velocity=1.2,
    min_angular_velocity=0.1,
    angular_deceleration=1.5,
    latency=0.12,
)
AT = SE2(2.0, 1.5)


def line(length: float, side: float = 1.0, start: SE2 = AT) -> NDArray[np.float64]:
    """Return poses straight ahead, or back, each 5 cm."""
    steps = np.linspace(0.0, side * length, round(length / 0.05) + 1)
    return np.array([(start @ SE2(x)).array() for x in steps])


def turn(angle: float, start: SE2 = AT) -> NDArray[np.float64]:
    steps = np.linspace(0.0, angle, 12)
    return np.array([(start @ SE2(0.0, 0.0, a)).array() for a in steps])


def tracking(
    trajectory: NDArray[np.float64],
    config: TrackerConfig = CONFIG,
    through: bool = False,
    blend: float = 0.0,
) -> Tracker:
    tracker = Tracker(config, blend)
    tracker.follow(trajectory, through)
    return tracker


def commanded(
    tracker: Tracker, pose: SE2, velocity: Velocity = STILL, speed: float = 0.3
) -> Velocity:
    command = tracker.compute(pose, velocity, speed)
    assert command is not None
    return command


def test_a_trajectory_is_cut_where_the_robot_stops() -> None:
    there = AT @ SE2(1.0, 0.0, 0.8)
    bend = np.array([AT.array(), (AT @ SE2.exp((0.1, 0.0, 0.2))).array()])
    whole = np.vstack((line(1.0), turn(0.8, AT @ SE2(1.0))[1:], line(0.5, -1.0, there)[1:]))
    assert [piece.direction for piece in pieces_of(whole)] == [1, 0, -1]
    assert [len(piece.poses) for piece in pieces_of(whole)] == [21, 12, 11]
    assert [piece.direction for piece in pieces_of(np.vstack((turn(0.5), turn(-0.4)[1:])))] == [
        0,
        0,
    ]
    assert [piece.direction for piece in pieces_of(bend)] == [1]
    wrapped = np.array([[0.0, 0.0, 3.1], [-0.1, 0.0, -3.1]])
    assert [piece.direction for piece in pieces_of(wrapped)] == [1]


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("left", "driving"), [(0.45, 0.0), (0.08, 0.2), (0.02, 0.1), (0.06, 0.0)])
def test_it_brakes_by_the_delay_of_commands(side: float, left: float, driving: float) -> None:
    tracker = tracking(line(1.0, side))
    pose, velocity = AT @ SE2(side * (1.0 - left)), Velocity(side * driving)
    command = commanded(tracker, pose, velocity)
    braked = math.sqrt(2.0 * 0.5 * max(left - 0.12 * driving, 0.0))
    assert command.x == pytest.approx(side * min(0.3, max(braked, 0.04)))
    assert command.yaw_rate == pytest.approx(0.0, abs=1e-9)


def test_it_does_not_brake_in_a_bend_whose_end_lies_behind() -> None:
    angles = np.linspace(0.0, 1.25 * math.pi, 60)
    bend = np.column_stack((0.5 * np.sin(angles), 0.5 - 0.5 * np.cos(angles), angles))
    end = SE2.from_array(bend[-1])
    tracker = tracking(np.vstack((bend, line(0.1, -1.0, end)[1:])))
    command = commanded(tracker, SE2.from_array(bend[8]))
    assert command.x == pytest.approx(0.3)
    command = commanded(tracker, SE2.from_array(bend[-2]))
    assert 0.04 < command.x < 0.3


def test_what_runs_out_ends_without_a_stop() -> None:
    assert commanded(tracking(line(1.0), through=True), AT @ SE2(0.95)).x == 0.3
    back = tracking(line(1.0, -1.0), through=True)
    assert not back.runs_out
    assert commanded(back, AT @ SE2(-0.95)).x > -0.3
    two = tracking(np.vstack((line(1.0, -1.0), line(0.5, 1.0, AT @ SE2(-1.0)))), through=True)
    assert not two.runs_out


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
def test_a_turn_comes_to_rest_at_its_end(angle: float, rate: float) -> None:
    command = commanded(tracking(turn(angle)), AT, Velocity(yaw_rate=rate))
    assert (command.x, command.yaw_rate) == pytest.approx((0.0, turned(angle, rate)))


@pytest.mark.parametrize(
    ("off", "rate", "ends"),
    [
        *((0.014, 0.0, True), (0.016, 0.0, False), (-0.016, 0.0, False)),
        *((0.0, 0.2, True), (0.0, 0.3, False), (0.0, -0.3, False)),
    ],
)
def test_a_turn_ends_where_it_is_and_stays_exact(off: float, rate: float, ends: bool) -> None:
    tracker = tracking(turn(1.0))
    pose = AT @ SE2(0.0, 0.0, 1.0 - off)
    assert (tracker.compute(pose, Velocity(yaw_rate=rate), 0.3) is None) is ends


@pytest.mark.parametrize(
    ("off", "aside", "ends"),
    [
        *((0.009, 0.0, True), (0.011, 0.0, False), (-0.2, 0.0, True)),
        *((0.004, 0.1, True), (0.006, 0.1, False)),
    ],
)
def test_a_stretch_ends_where_it_is_exact_or_passed(off: float, aside: float, ends: bool) -> None:
    for side in (1.0, -1.0):
        tracker = tracking(line(1.0, side))
        pose = AT @ SE2(side * (1.0 - off), aside)
        assert (tracker.compute(pose, STILL, 0.3) is None) is ends


def test_a_stretch_is_driven_though_its_end_lies_behind_a_robot_that_turned_too_far() -> None:
    angles = np.linspace(0.0, -1.2, 25)
    arc = np.array([(SE2(2.0, 1.5) @ SE2.exp((-a, 0.0, a))).array() for a in angles])
    assert commanded(tracking(arc), SE2(2.0, 1.5, 2.2)).x > 0.0


@pytest.mark.parametrize("aside", [0.0, 0.03, -0.05])
@pytest.mark.parametrize("speed", [0.3, 0.1])
def test_it_steers_to_a_pose_ahead_by_the_time_of_its_lookahead(aside: float, speed: float) -> None:
    config = replace(
        CONFIG,
        lookahead_time=0.5,
        min_lookahead=0.12,
        max_angular_velocity=9.0,
        lateral_acceleration=9.0,
    )
    tracker = tracking(line(1.0), config, through=True)
    command = commanded(tracker, AT @ SE2(0.2, aside), speed=speed)
    assert command.x == speed
    ahead = math.sqrt(max(0.5 * speed, 0.12) ** 2 - aside**2)
    expected = speed * curvature_into(SE2(ahead, -aside))
    assert command.yaw_rate == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_keeps_a_bend_that_unbends(side: float) -> None:
    bends = side * np.linspace(2.0, 0.0, 101)  # over a metre
    poses = [AT]
    for bend in bends:
        poses.append(poses[-1] @ SE2.exp((0.01 * side, 0.0, 0.01 * bend * side)))
    trajectory = np.array([pose.array() for pose in poses])
    tracker = tracking(trajectory, replace(CONFIG, lateral_acceleration=9.0))
    command = commanded(tracker, poses[20], speed=0.3)
    assert command.yaw_rate / command.x == pytest.approx(bends[20], rel=0.05)


def test_it_slows_down_where_it_would_drift() -> None:
    fast, slow = (
        commanded(
            tracking(line(1.0), replace(CONFIG, max_angular_velocity=9.0, lateral_acceleration=a)),
            AT @ SE2(0.2, -0.02),
        )
        for a in (9.0, 0.05)
    )
    assert abs(slow.x * slow.yaw_rate) == pytest.approx(0.05)
    assert slow.yaw_rate / slow.x == pytest.approx(fast.yaw_rate / fast.x)


def test_it_keeps_the_bend_where_its_yaw_rate_is_limited() -> None:
    wide, narrow = (
        commanded(
            tracking(line(1.0), replace(CONFIG, max_angular_velocity=rate)), AT @ SE2(0.2, -0.1)
        )
        for rate in (9.0, 0.5)
    )
    assert narrow.yaw_rate == pytest.approx(0.5)
    assert narrow.yaw_rate / narrow.x == pytest.approx(wide.yaw_rate / wide.x)


@pytest.mark.parametrize("left", [0.051, 0.04, 0.02])
@pytest.mark.parametrize("aside", [0.0, 0.01])
@pytest.mark.parametrize("angle", [0.3, -2.0])
def test_the_next_turn_begins_before_the_end(left: float, aside: float, angle: float) -> None:
    both = np.vstack((line(1.0), turn(angle, AT @ SE2(1.0))[1:]))
    pose, share = AT @ SE2(1.0 - left, aside), max(1.0 - math.hypot(left, aside) / 0.05, 0.0)
    command = commanded(tracking(both, blend=0.05), pose, Velocity(0.1))
    alone = commanded(tracking(line(1.0), blend=0.05), pose, Velocity(0.1))
    assert command.x > 0.0
    assert (alone.yaw_rate < -1e-3) is (aside > 0.0), "it steers back to the line"
    mixed = share * turned(angle, 0.0) + (1.0 - share) * alone.yaw_rate
    assert command.yaw_rate == pytest.approx(mixed, abs=1e-6)


def test_the_rest_lies_ahead_of_the_robot_as_far_as_it_is_asked_for() -> None:
    tracker, pose = tracking(line(1.0)), AT @ SE2(0.3, 0.01)
    rest = tracker.rest(pose, 0.21)
    np.testing.assert_allclose(rest[0], pose.array())
    np.testing.assert_allclose(rest[1:, 0], 2.3 + np.arange(1, 5) * 0.05)
    rest = tracking(turn(1.0)).rest(AT @ SE2(0.0, 0.0, 0.4), 0.0)
    assert (rest[0, 2], rest[-1, 2]) == pytest.approx((0.4, 1.0))
    assert np.abs(np.diff(rest[:, 2])).max() <= 0.1


@pytest.mark.parametrize("drift", [-0.15, 0.0, 0.15])
def test_a_turn_stays_where_wheels_slip_ahead(drift: float) -> None:
    tracker, pose, velocity = tracking(turn(2.5)), AT, STILL
    for _ in range(150):
        if (command := tracker.compute(pose, velocity, 0.3)) is None:
            break
        velocity = command
        slipped = command.x + drift * abs(command.yaw_rate)
        pose = pose @ SE2.exp(np.array([slipped, 0.0, command.yaw_rate]) * 0.05)
    assert not tracker.pieces
    assert pose.distance(AT) < (0.08 if drift else 0.001)  # 0.3 m where nothing holds it
