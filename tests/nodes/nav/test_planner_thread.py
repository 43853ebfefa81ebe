"""planner_server outside lock-step: a thread plans, and goals end at once where they should."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from geometry_msgs.msg import PoseArray
from nav2_msgs.action import ComputePathToPose
from visualization_msgs.msg import MarkerArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import PlanResult, PlanStatus
from arjuna_nav.planners.base import check_stopped
from bringup.stack import GLOBAL_COSTMAP, PLANNER_SERVER
from tests.helpers.nav.navigation import (
    ABORTED,
    CANCELED,
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
)
from tests.helpers.nav.navigator_goals import stamped
from tests.helpers.processes import wait_until

Result = ComputePathToPose.Result


@dataclass(frozen=True)
class SlowConfig:
    """Parameters of `Slow`."""

    max_planning_time: float = param(1.0, "After which a plan ends.", unit="s")


class Slow:
    """Plans until the test releases it or its plan is to stop."""

    Config: ClassVar[type[Any]] = SlowConfig
    release = threading.Event()
    outcomes: ClassVar[list[str]] = []

    def __init__(self, config: SlowConfig, footprint: Footprint) -> None:
        pass

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        outcomes = self.outcomes  # of this test: a plan may outlast it
        try:
            while not self.release.wait(0.001):
                check_stopped()
        except BaseException:
            outcomes.append("stopped")
            raise
        if goal.x < 0.0:
            raise RuntimeError("behind")
        outcomes.append("planned")
        return PlanResult(PlanStatus.SUCCEEDED, np.array([start.array(), goal.array()]))


PARAMETERS: dict[str, Any] = {
    "expected_planner_frequency": 2.0,
    "planner_plugins": ["GridBased", "Slow", "Hybrid"],
    "Slow": {"plugin": f"{__name__}:Slow"},
    "Hybrid": {"plugin": "nav2_smac_planner::SmacPlannerHybrid", "debug_visualizations": True},
}


@pytest.fixture
def robot() -> Iterator[PlayedRobot]:
    """Return a robot whose planner server has a thread."""
    Slow.release.clear()
    Slow.outcomes = []
    robot = PlayedRobot({"planner_server": PARAMETERS})
    robot.bench.process.isolated = False
    robot.bench.process.guard.strict = False
    robot.bring_up(GLOBAL_COSTMAP, PLANNER_SERVER)
    robot.send_map()
    robot.run(1.0)
    yield robot
    Slow.release.set()
    robot.close()


def to_pose(robot: PlayedRobot, x: float, planner: str) -> Goal:
    request = ComputePathToPose.Goal(goal=stamped(SE2(x, 0.5)), planner_id=planner)
    return robot.send(ComputePathToPose, "compute_path_to_pose", request)


def finished(robot: PlayedRobot, goal: Goal) -> None:
    """Wait for a goal while time stands still."""
    wait_until(lambda: goal.done, robot.bench.process.drain, "the goal to end")


def test_a_cancel_is_answered_while_a_plan_is_made(robot: PlayedRobot) -> None:
    goal = to_pose(robot, 2.0, "Slow")
    robot.run(0.2)
    assert not goal.done
    goal.cancel()
    assert goal.status == CANCELED
    wait_until(lambda: Slow.outcomes, robot.bench.process.drain, "the plan to stop")
    assert Slow.outcomes == ["stopped"]


def test_a_newer_goal_does_not_wait_for_an_older_ones_plan(robot: PlayedRobot) -> None:
    older = to_pose(robot, 2.0, "Slow")
    newer = to_pose(robot, 1.5, "GridBased")
    assert older.status == ABORTED
    finished(robot, newer)
    assert newer.status == SUCCEEDED
    assert newer.result.path.poses[-1].pose.position.x == 1.5
    assert Slow.outcomes == ["stopped"]


def test_a_plan_ends_after_max_planning_time(robot: PlayedRobot) -> None:
    goal = to_pose(robot, 2.0, "Slow")
    robot.run(0.9)
    assert not goal.done
    robot.run(0.4)
    assert_failed(goal, Result.TIMEOUT, "max_planning_time = 1 s")


def test_slow_plans_are_reported(robot: PlayedRobot, capfd: pytest.CaptureFixture[str]) -> None:
    for wait, noted in ((0.3, False), (0.7, True)):
        goal = to_pose(robot, 2.0, "Slow")
        robot.run(wait)
        Slow.release.set()
        finished(robot, goal)
        Slow.release.clear()
        assert goal.status == SUCCEEDED
        assert ("1 / expected_planner_frequency is 0.50" in capfd.readouterr().err) is noted


def test_a_planner_that_raises_fails_its_goal(robot: PlayedRobot) -> None:
    Slow.release.set()
    goal = to_pose(robot, -2.0, "Slow")
    finished(robot, goal)
    assert_failed(goal, Result.UNKNOWN, "RuntimeError: behind")


def test_the_server_stops_its_plans_where_it_is_deactivated(robot: PlayedRobot) -> None:
    goal = to_pose(robot, 2.0, "Slow")
    robot.transition("planner_server", "deactivate")
    assert goal.status == ABORTED
    wait_until(lambda: Slow.outcomes, robot.bench.process.drain, "the plan to stop")
    assert Slow.outcomes == ["stopped"]


def test_expansions_and_footprints_are_published_where_asked(robot: PlayedRobot) -> None:
    expansions = robot.bench.collect(PoseArray, "/expansions")
    footprints = robot.bench.collect(MarkerArray, "/planned_footprints")
    goal = to_pose(robot, 2.0, "Hybrid")
    finished(robot, goal)
    robot.bench.process.drain()
    assert expansions[0].header.frame_id == "map"
    assert (expansions[0].poses[0].position.x, expansions[0].poses[0].position.y) == (0.0, 0.0)
    corners = len(footprints[0].markers[0].points)
    assert corners >= 2 * 3 * len(goal.result.path.poses)
