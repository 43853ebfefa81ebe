"""Plug-ins of the servers: several at once, chosen by the goal or on a topic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nav2_msgs.action import ComputePathToPose, FollowPath, NavigateToPose, SmoothPath
from nav_msgs.msg import Path
from rcl_interfaces.srv import GetParameters
from std_msgs.msg import String

from arjuna_core.ros import qos
from arjuna_core.ros.convert import path_msg, pose_stamped, poses_from_path
from arjuna_core.se2 import SE2
from bringup.stack import (
    CONTROLLER_SERVER,
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    NAVIGATION_GROUP,
    PLANNER_SERVER,
    SMOOTHER_SERVER,
)
from tests.helpers.nav.controllers import OWN, PARAMETERS
from tests.helpers.nav.navigation import SUCCEEDED, Goal, PlayedRobot, started
from tests.nav.worlds import polyline

CONTROLLERS: dict[str, Any] = {
    "controller_plugins": ["FollowPath", "Crawl", *(f"c{k}" for k in range(len(PARAMETERS)))],
    "Crawl.plugin": "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
    "Crawl.desired_linear_vel": 0.07,
    "goal_checker_plugins": ["general_goal_checker", "standing", "anyhow"],
    "standing.plugin": "nav2_controller::StoppedGoalChecker",
    "anyhow.plugin": "nav2_controller/PositionGoalChecker",
    "anyhow.xy_goal_tolerance": 0.4,
    "progress_checker_plugins": ["progress_checker", "turning"],
    "turning.plugin": "nav2_controller::PoseProgressChecker",
    **{
        f"c{k}.{name}": value
        for k, values in enumerate(PARAMETERS.values())
        for name, value in values.items()
    },
}
PLANNERS: dict[str, Any] = {
    "planner_plugins": ["GridBased", "Theta"],
    "Theta.plugin": "nav2_theta_star_planner/ThetaStarPlanner",
}
SMOOTHERS: dict[str, Any] = {
    "smoother_plugins": ["simple_smoother", "once"],
    "once.plugin": "nav2_smoother::SimpleSmoother",
    "once.max_its": 1,
    "once.do_refinement": False,
}


@pytest.fixture
def controlled() -> PlayedRobot:
    return started(LOCAL_COSTMAP, CONTROLLER_SERVER, settle=0.5, controller_server=CONTROLLERS)


def follow(robot: PlayedRobot, **ids: str) -> Goal:
    route = path_msg(polyline([(0.0, 0.0), (1.2, 0.0)], 0.0), "map", 0.0)
    return robot.send(FollowPath, "follow_path", FollowPath.Goal(path=route, **ids))


@pytest.mark.parametrize("k", range(len(OWN)), ids=list(OWN))  # with or without the shim
def test_every_controller_follows_in_the_server(controlled: PlayedRobot, k: int) -> None:
    goal = follow(controlled, controller_id=f"c{k}")
    controlled.run_until_done(goal, 20.0)
    assert goal.status == SUCCEEDED, goal.result.error_msg
    assert controlled.pose.distance(SE2(1.2, 0.0)) < 0.16


def test_a_controller_is_chosen_by_the_goal(controlled: PlayedRobot) -> None:
    follow(controlled, controller_id="Crawl")
    controlled.run(1.0)
    assert controlled.command.x == pytest.approx(0.07)
    follow(controlled, controller_id="FollowPath")
    controlled.run(1.5)
    assert controlled.command.x > 0.3


def test_its_parameters_are_the_node_s(controlled: PlayedRobot) -> None:
    request = GetParameters.Request(
        names=["Crawl.desired_linear_vel", "Crawl.plugin", "controller_plugins"]
    )
    values = controlled.bench.call(
        GetParameters, "/controller_server/get_parameters", request
    ).values
    assert values[0].double_value == 0.07
    assert values[1].string_value == CONTROLLERS["Crawl.plugin"]
    assert list(values[2].string_array_value) == CONTROLLERS["controller_plugins"]


def test_the_goal_chooses_its_checkers(controlled: PlayedRobot) -> None:
    goal = follow(controlled, goal_checker_id="anyhow", progress_checker_id="turning")
    controlled.succeed(goal, 10.0)
    controlled.succeed(follow(controlled, goal_checker_id="standing"), 10.0)
    assert abs(controlled.command.x) < 0.25


@pytest.fixture
def planning() -> PlayedRobot:
    nodes = (GLOBAL_COSTMAP, PLANNER_SERVER, SMOOTHER_SERVER)
    return started(*nodes, planner_server=PLANNERS, smoother_server=SMOOTHERS)


def plan(robot: PlayedRobot, name: str) -> Any:
    target = pose_stamped(SE2(4.0, 1.0), "map", 0.0)
    request = ComputePathToPose.Goal(goal=target, planner_id=name)
    goal = robot.send(ComputePathToPose, "compute_path_to_pose", request)
    robot.succeed(goal, 3.0)
    return goal.result.path


def test_planners_and_smoothers_are_chosen_by_the_goal(planning: PlayedRobot) -> None:
    lengths = {}
    for name in ("", "GridBased", "Theta"):
        points = poses_from_path(plan(planning, name))[:, :2]
        lengths[name] = len(points), float(np.hypot(*np.diff(points, axis=0).T).sum())
    assert lengths[""] == lengths["GridBased"]
    assert lengths["Theta"][0] != lengths["GridBased"][0]
    assert lengths["Theta"][1] < lengths["GridBased"][1] + 0.2
    smoothed = []
    for name in ("once", "simple_smoother"):
        request = SmoothPath.Goal(path=plan(planning, ""), smoother_id=name)
        goal = planning.send(SmoothPath, "smooth_path", request)
        planning.run_until_done(goal, 3.0)
        smoothed.append(poses_from_path(goal.result.path))
    assert np.abs(smoothed[0] - smoothed[1]).max() > 1e-3


def test_a_selector_topic_chooses_for_the_navigator() -> None:
    robot = PlayedRobot({"controller_server": CONTROLLERS, "planner_server": PLANNERS})
    robot.bring_up(*NAVIGATION_GROUP.nodes)
    robot.send_map()
    plans = robot.bench.collect(Path, "/plan")
    for topic, name in (("/controller_selector", "Crawl"), ("/planner_selector", "Theta")):
        robot.bench.publish(String, topic, String(data=name), qos.LATCHED)
    robot.run(1.0)
    counts = [len(plan(robot, name).poses) for name in ("Theta", "GridBased")]
    plans.clear()
    goal = NavigateToPose.Goal(pose=pose_stamped(SE2(4.0, 1.0), "map", 0.0))
    robot.send(NavigateToPose, "navigate_to_pose", goal)
    robot.run(2.0)
    assert robot.command.x == pytest.approx(0.07)
    assert len(plans[0].poses) == counts[0] != counts[1]
