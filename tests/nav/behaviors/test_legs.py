"""Legs: a motion ends where it was asked to, at the speeds that it may have."""

from __future__ import annotations

import math

import pytest

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL
from arjuna_nav.behaviors.base import InvalidGoalError
from arjuna_nav.behaviors.legs import Leg, Legs, Step, arc, to_position
from arjuna_nav.controllers.tracker import TrackerConfig

PERIOD = 0.025


def driven(steps: list[Step], start: SE2 = IDENTITY) -> tuple[SE2, list[tuple[float, float]]]:
    """Return where the legs end, and the speeds and yaw rates on the way."""
    legs, pose, speeds = Legs(steps, TrackerConfig(latency=0.0)), start, []
    velocity = STILL
    while (command := legs.tick(pose, velocity)) is not None:
        velocity = command
        speeds.append((velocity.x, velocity.yaw_rate))
        assert len(speeds) < 2000
        angle = velocity.yaw_rate * PERIOD
        chord = velocity.x * PERIOD
        pose = pose @ SE2(chord * math.cos(angle / 2), chord * math.sin(angle / 2), angle)
    return pose, speeds


@pytest.mark.parametrize(
    ("steps", "start", "expected"),
    [
        ([lambda pose: Leg(0.5)], SE2(1.0, 1.0, math.pi / 2), SE2(1.0, 1.5, math.pi / 2)),
        ([lambda pose: Leg(-0.3)], SE2(), SE2(-0.3, 0.0, 0.0)),
        ([lambda pose: Leg(angle=-2.0)], SE2(1.0, 0.0, 2.5), SE2(1.0, 0.0, 0.5)),
        ([lambda pose: Leg(angle=7.0)], SE2(), SE2(0.0, 0.0, 7.0 - 2 * math.pi)),
        ([lambda pose: arc(math.pi / 2, 0.5, 1, 0.3)], SE2(), SE2(0.5, 0.5, math.pi / 2)),
        ([lambda pose: arc(math.pi / 2, 0.5, -1, 0.3)], SE2(), SE2(-0.5, -0.5, math.pi / 2)),
        (to_position(SE2(1.0, -1.0, 2.0), True), SE2(), SE2(1.0, -1.0, 2.0)),
        (to_position(SE2(0.0, 1.0, 2.0), False), SE2(), SE2(0.0, 1.0, math.pi / 2)),
        ([], SE2(1.0, 2.0, 0.5), SE2(1.0, 2.0, 0.5)),
    ],
)
def test_a_motion_ends_where_it_was_asked_to(steps: list[Step], start: SE2, expected: SE2) -> None:
    pose, speeds = driven(steps, start)
    assert pose.distance(expected) < 0.02
    assert math.cos(pose.theta - expected.theta) > math.cos(0.03)
    assert all(abs(x) <= 0.3 + 1e-9 and abs(rate) <= 1.9 + 1e-9 for x, rate in speeds)


def test_it_slows_down_before_the_end() -> None:
    speeds = [x for x, _ in driven([lambda pose: Leg(1.0)])[1]]
    assert speeds[-1] < 0.15
    assert max(speeds) == pytest.approx(0.3)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Leg(math.nan),
        lambda: Leg(1.0, speed=0.0),
        lambda: Leg(angle=1.0, rate=-1.0),
        lambda: arc(1.0, 0.0, 1, 0.3),
        lambda: arc(1.0, 0.5, 0, 0.3),
    ],
)
def test_what_is_no_motion_is_refused(wrong: object) -> None:
    assert callable(wrong)
    with pytest.raises(InvalidGoalError, match=r"must be finite|valid"):
        wrong()
