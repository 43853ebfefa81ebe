"""smoother_server: smooth paths, and the reasons of its refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from nav2_msgs.action import SmoothPath
from nav_msgs.msg import Path

from arjuna_core.ros.convert import path_msg, poses_from_path
from arjuna_core.se2 import SE2
from bringup.stack import GLOBAL_COSTMAP, SMOOTHER_SERVER
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, assert_failed, started
from tests.nav.worlds import polyline

Result = SmoothPath.Result
CORNER = polyline([(0.0, 0.0), (1.5, 0.0), (1.5, 1.5)], 0.5)


def made() -> PlayedRobot:
    return started(GLOBAL_COSTMAP, SMOOTHER_SERVER)


def smooth(robot: PlayedRobot, poses: Any = CORNER, frame: str = "map", **fields: Any) -> Goal:
    route = poses if isinstance(poses, Path) else path_msg(poses, frame, 0.0)
    return robot.send(SmoothPath, "smooth_path", SmoothPath.Goal(path=route, **fields))


def sharpest_turn(poses: Any) -> float:
    headings = np.arctan2(*np.diff(poses[:, :2], axis=0).T[::-1])
    return float(np.abs(np.diff(np.unwrap(headings))).max())


def test_a_corner_is_rounded_and_the_path_published(robot: PlayedRobot) -> None:
    published = robot.bench.collect(Path, "/plan_smoothed")
    for smoother in ("", "simple_smoother"):
        goal = smooth(robot, smoother_id=smoother, check_for_collisions=True)
        assert (goal.status, goal.result.error_code) == (SUCCEEDED, 0)
        assert goal.result.was_completed
        poses = poses_from_path(goal.result.path)
        assert sharpest_turn(poses) < 0.5 * sharpest_turn(CORNER)
        assert poses[-1] == pytest.approx(CORNER[-1])
        assert goal.result.path.header.frame_id == "map"
        assert published[-1].poses == goal.result.path.poses


def test_the_constrained_smoother_turns_no_tighter_than_its_robot_and_off_walls() -> None:
    plugin = "nav2_constrained_smoother/ConstrainedSmoother"
    values = {"smoother_plugins": ["bent"], "bent.plugin": plugin, "bent.optimizer.fn_tol": 1e-6}
    robot = started(GLOBAL_COSTMAP, SMOOTHER_SERVER, smoother_server=values)
    along_wall = polyline([(-1.0, 4.7), (1.5, 4.7)], 0.0)
    goal = smooth(robot, along_wall, smoother_id="bent")
    assert (goal.status, goal.result.was_completed) == (SUCCEEDED, True)
    poses = poses_from_path(goal.result.path)
    assert poses[len(poses) // 2, 1] < 4.65
    assert poses[[0, -1]] == pytest.approx(along_wall[[0, -1]])
    assert sharpest_turn(poses) < 0.05 / 0.4


def test_a_pass_into_an_obstacle_is_undone(robot: PlayedRobot) -> None:
    through_wall = polyline([(0.0, 0.0), (5.2, 0.0)], 0.0)
    goal = smooth(robot, through_wall)
    assert (goal.status, goal.result.was_completed) == (SUCCEEDED, False)
    assert "as it was before" in goal.result.error_msg
    assert poses_from_path(goal.result.path)[:, :2] == pytest.approx(through_wall[:, :2])


def test_a_path_of_another_frame_is_smoothed_where_it_lies(robot: PlayedRobot) -> None:
    robot.pose = SE2(3.0, 0.0)
    robot.run(1.0)
    ahead = polyline([(0.0, 0.0), (1.9, 0.0)], 0.0)  # into the wall at x = 5, seen from the robot
    assert not smooth(robot, ahead, "base_link").result.was_completed
    assert smooth(robot, ahead, "map").result.was_completed


def not_finite() -> Path:
    route = path_msg(CORNER, "map", 0.0)
    route.poses[1].pose.position.y = math.nan
    return route


def test_what_cannot_be_smoothed_fails_with_its_code(robot: PlayedRobot) -> None:
    into_wall = polyline([(0.0, 0.0), (4.8, 0.0)], 0.0)
    cases: list[tuple[int, dict[str, Any]]] = [
        (Result.INVALID_SMOOTHER, {"smoother_id": "Best"}),
        (Result.INVALID_PATH, {"poses": Path()}),
        (Result.INVALID_PATH, {"poses": not_finite()}),
        (Result.INVALID_PATH, {"frame": "moon"}),
        (Result.SMOOTHED_PATH_IN_COLLISION, {"poses": into_wall, "check_for_collisions": True}),
    ]
    for code, fields in cases:
        assert_failed(smooth(robot, **fields), code)
    robot.localized = False
    robot.run(2.0)
    assert_failed(smooth(robot), Result.UNKNOWN)  # the costmap is not current


def test_without_costs_on_its_topic_nothing_is_smoothed() -> None:
    values = {"costmap_topic": "elsewhere/costmap_raw"}
    robot = started(GLOBAL_COSTMAP, SMOOTHER_SERVER, smoother_server=values)
    goal = smooth(robot)
    robot.run(3.0)
    assert_failed(goal, Result.UNKNOWN)
