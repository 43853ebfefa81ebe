"""Goal and progress checkers."""

from __future__ import annotations

import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.checkers import (
    GoalConfig,
    PoseProgressChecker,
    PoseProgressConfig,
    PositionGoalChecker,
    PositionGoalConfig,
    ProgressConfig,
    SimpleGoalChecker,
    SimpleProgressChecker,
    StoppedGoalChecker,
    StoppedGoalConfig,
)

GOAL = SE2(1.0, 0.0, 3.1)


def test_arrives_with_position_and_heading() -> None:
    checker = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, yaw_goal_tolerance=0.15))
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)
    assert not checker.reached(SE2(0.9, 0.0, 2.9), GOAL)
    assert checker.reached(SE2(0.9, 0.0, -3.12), GOAL), "headings wrap"


@pytest.mark.parametrize(
    ("x", "yaw", "arrives"),
    [(0.75, 0.5, True), (0.749, 0.5, False), (0.75, 0.501, False), (0.75, -0.5, True)],
)
def test_a_tolerance_is_tolerated_to_its_edge(x: float, yaw: float, arrives: bool) -> None:
    config = GoalConfig(xy_goal_tolerance=0.25, yaw_goal_tolerance=0.5)
    assert SimpleGoalChecker(config).reached(SE2(x, 0.0, yaw), SE2(1.0)) is arrives
    at_any = PositionGoalChecker(PositionGoalConfig(0.25))
    assert at_any.reached(SE2(x), SE2(1.0)) is (x == 0.75)


@pytest.mark.parametrize("stateful", [True, False])
@pytest.mark.parametrize("heading", [True, False])
def test_a_position_once_reached_stays_reached_where_stateful(
    heading: bool, stateful: bool
) -> None:
    simple = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, stateful=stateful))
    checker = simple if heading else PositionGoalChecker(PositionGoalConfig(0.2, stateful))
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)
    assert checker.reached(SE2(0.9, 0.0, 1.0), GOAL) is not heading
    assert checker.reached(SE2(0.7, 0.0, 3.1), GOAL) is stateful
    checker.reset()
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)


@pytest.mark.parametrize(
    "checker",
    [
        SimpleGoalChecker(GoalConfig(0.2, yaw_goal_tolerance=3.2)),
        PositionGoalChecker(PositionGoalConfig(0.2)),
    ],
)
def test_who_was_pushed_away_from_a_goal_has_not_arrived(
    checker: SimpleGoalChecker | PositionGoalChecker,
) -> None:
    assert checker.reached(SE2(0.9, 0.0, 0.0), GOAL)
    assert not checker.reached(SE2(0.4, 0.0, 0.0), GOAL)
    assert not checker.reached(SE2(0.7, 0.0, 0.0), GOAL), "it has to come back"
    assert checker.reached(SE2(0.9, 0.0, 0.0), GOAL)


def test_arrives_backwards_too_where_that_is_as_good() -> None:
    for symmetric in (True, False):
        checker = SimpleGoalChecker(GoalConfig(symmetric_yaw_tolerance=symmetric))
        assert checker.reached(SE2(1.0, 0.0, 0.1), GOAL) is symmetric
        assert checker.reached(SE2(1.0, 0.0, -3.1), GOAL)
        assert not checker.reached(SE2(1.0, 0.0, 1.6), GOAL)


@pytest.mark.parametrize(
    ("velocity", "stands"),
    [
        (Velocity(0.25, yaw_rate=-0.25), True),
        (Velocity(-0.25, yaw_rate=0.25), True),
        (Velocity(0.3), False),
        (Velocity(-0.3), False),
        (Velocity(yaw_rate=-0.3), False),
    ],
)
def test_arrives_only_once_it_stands(velocity: Velocity, stands: bool) -> None:
    checker = StoppedGoalChecker(StoppedGoalConfig())
    assert checker.reached(GOAL, GOAL, velocity) is stands
    assert not checker.reached(SE2(0.0, 0.0, 0.0), GOAL, velocity)


def test_turning_is_progress_where_the_pose_counts() -> None:
    config = PoseProgressConfig(0.5, 10.0, required_movement_angle=0.5)
    checker = PoseProgressChecker(config)
    assert checker.check(SE2(0.0, 0.0, 3.1), 0.0)
    assert checker.check(SE2(0.0, 0.0, -2.6), 9.0), "headings wrap"
    assert not checker.check(SE2(0.0, 0.0, -2.2), 19.1)
    assert "turned less than 0.5 rad and" in checker.failure_message()
    assert checker.check(SE2(0.6, 0.0, -2.2), 19.2)


def test_asks_for_movement_within_the_time_allowed() -> None:
    config = ProgressConfig(required_movement_radius=0.5, movement_time_allowance=10.0)
    checker = SimpleProgressChecker(config)
    assert checker.check(SE2(), 0.0)
    assert checker.check(SE2(0.4, 0.0), 10.0)
    assert not checker.check(SE2(0.4, 0.0), 10.1)
    assert checker.check(SE2(0.6, 0.0), 10.2)
    assert checker.check(SE2(0.6, 0.0), 20.2)
    assert not checker.check(SE2(0.6, 0.0), 20.3)
    checker.reset()
    assert checker.check(SE2(0.6, 0.0), 20.4)


@pytest.mark.parametrize("pose", [SE2(0.5, 0.0, 0.0), SE2(0.0, 0.0, -0.5), SE2(0.3, 0.4, 0.5)])
def test_just_as_far_as_is_required_is_not_yet_progress(pose: SE2) -> None:
    checker = PoseProgressChecker(PoseProgressConfig(0.5, 10.0, required_movement_angle=0.5))
    assert checker.check(SE2(), 0.0)
    assert checker.check(pose, 10.0)
    assert not checker.check(pose, 10.1)
    assert checker.failure_message() == "turned less than 0.5 rad and moved less than 0.5 m in 10 s"
