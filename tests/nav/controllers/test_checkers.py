"""Goal and progress checkers."""

from __future__ import annotations

from arjuna_core.se2 import SE2
from arjuna_nav.controllers.checkers import (
    GoalConfig,
    ProgressConfig,
    SimpleGoalChecker,
    SimpleProgressChecker,
)

GOAL = SE2(1.0, 0.0, 3.1)


def test_arrives_with_position_and_heading() -> None:
    checker = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, yaw_goal_tolerance=0.15))
    assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)
    assert not checker.reached(SE2(0.9, 0.0, 2.9), GOAL)
    assert checker.reached(SE2(0.9, 0.0, -3.12), GOAL), "headings wrap"


def test_a_position_once_reached_stays_reached_where_stateful() -> None:
    for stateful in (True, False):
        checker = SimpleGoalChecker(GoalConfig(xy_goal_tolerance=0.2, stateful=stateful))
        checker.reached(SE2(0.9, 0.0, 0.0), GOAL)
        assert checker.reached(SE2(0.7, 0.0, 3.1), GOAL) is stateful
        checker.reset()
        assert not checker.reached(SE2(0.7, 0.0, 3.1), GOAL)


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
