"""A user's own plug-ins, one of each kind: the files of docs/plugins.md, in one navigation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nav2_msgs.action import (
    ComputeAndTrackRoute,
    ComputePathToPose,
    FollowPath,
    FollowWaypoints,
    NavigateToPose,
    SmoothPath,
    Wait,
)
from nav2_msgs.msg import CostmapFilterInfo
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, path_msg, pose_stamped, poses_from_path
from arjuna_core.se2 import SE2
from bringup.parameters.files import Parameters, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.stack import NAVIGATION_GROUP, ROUTE_SERVER, all_nodes
from tests.helpers.nav.navigation import SUCCEEDED, PlayedRobot, started
from tests.helpers.nav.plugins_page import parameters
from tests.helpers.nav.routes import square, written
from tests.nav.worlds import polyline

IS_EAST = """<root BTCPP_format="4"><BehaviorTree ID="Main">
<Fallback><IsEast line="{0}"/><AlwaysFailure/></Fallback></BehaviorTree></root>"""


MASK = GridFrame(0.1, 20, 20, SE2(-1.0, -1.0))


def page(folder: Path) -> dict[str, Any]:
    """Return the page's values by node, docks and trees in a folder."""
    values: dict[str, Any] = parameters(folder)
    values["bt_navigator"]["bt_folder"] = str(folder)
    values["docking_server"] |= {"docks": ["home"], "home.pose": [1.2, 0.4, 0.0]}
    return values


def made(values: Parameters) -> PlayedRobot:
    checked = understand(values, shipped_parameters(), all_nodes())
    robot = PlayedRobot(checked.parameters, shipped=False)
    robot.bring_up(*NAVIGATION_GROUP.nodes)
    robot.send_map()
    robot.run(1.0)
    return robot


@pytest.fixture
def robot(own_plugins: Path) -> PlayedRobot:
    return made(page(own_plugins))


def test_a_planner_a_smoother_a_behavior_and_a_dock(robot: PlayedRobot) -> None:
    pose = pose_stamped(SE2(2.0, 0.5), "map", 0.0)
    planning = ComputePathToPose.Goal(goal=pose, planner_id="Line")
    goal = robot.send(ComputePathToPose, "compute_path_to_pose", planning)
    robot.run_until_done(goal, 3.0)
    assert len(goal.result.path.poses) == 7
    route = polyline([(0.0, 0.0), (1.0, 0.0)], 0.0)
    smoothing = SmoothPath.Goal(path=path_msg(route, "map", 0.0), smoother_id="sparse")
    goal = robot.send(SmoothPath, "smooth_path", smoothing)
    robot.run_until_done(goal, 3.0)
    assert len(poses_from_path(goal.result.path)) == len(route) // 2 + 1
    goal = robot.send(Wait, "count", Wait.Goal())
    robot.succeed(goal, 3.0)
    assert [each.time_left.sec for each in goal.feedback] == [*range(9, 0, -1)]
    staging = robot.nodes["docking_server"]._book.types["side"].staging_pose(SE2(1.2, 0.4))
    assert staging.distance(SE2(1.2, 0.9)) < 1e-9


def test_a_controller_and_checkers(robot: PlayedRobot) -> None:
    route = path_msg(polyline([(0.0, 0.0), (0.5, 0.0)], 0.0), "map", 0.0)
    names = {"goal_checker_id": "line", "progress_checker_id": "patient"}
    request = FollowPath.Goal(path=route, controller_id="Crawl", **names)
    goal = robot.send(FollowPath, "follow_path", request)
    robot.run(2.0)
    assert robot.command.x == pytest.approx(0.07)
    robot.succeed(goal, 20.0)
    assert robot.pose.x >= 0.499


@pytest.mark.parametrize(("name", "side"), [("Window", -1.0), ("Cloud", 1.0)])
def test_a_critic(robot: PlayedRobot, name: str, side: float) -> None:
    route = path_msg(polyline([(0.0, 0.0), (2.0, 0.0)], 0.0), "map", 0.0)
    robot.send(FollowPath, "follow_path", FollowPath.Goal(path=route, controller_id=name))
    robot.run(1.5)
    assert side * robot.pose.y > 0.05
    assert name == "Cloud" or 0.0 < robot.command.x <= 0.25


def test_a_layer_and_a_filter(robot: PlayedRobot) -> None:
    layered = robot.nodes["local_costmap/local_costmap"].layered
    rows = layered.costmap.data.min(axis=1)
    assert rows[:20].tolist() == [*range(0, 100, 5)]
    assert layered.layers["counter"].inside == 0
    info = CostmapFilterInfo(type=0, filter_mask_topic="/mask", multiplier=1.0)
    robot.bench.publish(CostmapFilterInfo, "/costmap_filter_info", info, qos.LATCHED)
    robot.run(0.3)
    mask = grid_msg(OccupancyGrid(MASK, np.full(MASK.shape, 100, np.int8)), "map", robot.now)
    robot.bench.publish(OccupancyGridMsg, "/mask", mask, qos.LATCHED)
    robot.run(1.0)
    assert layered.layers["counter"].inside > 0


def test_a_task_and_a_navigator(robot: PlayedRobot, capfd: pytest.CaptureFixture[str]) -> None:
    poses = [pose_stamped(SE2(0.3 * k, 0.0), "map", 0.0) for k in (1, 2)]
    for name in ("follow_waypoints", "patrol"):
        request = FollowWaypoints.Goal(poses=poses, number_of_loops=0)
        robot.succeed(robot.send(FollowWaypoints, name, request), 30.0)
    log = capfd.readouterr().err
    assert "hello from waypoint 0" in log
    assert "hello from waypoint 1" in log
    assert robot.nodes["bt_navigator"]._trees.tree.blackboard.get("loops") == 0


def test_a_scorer_and_an_operation_of_routes(own_plugins: Path) -> None:
    graph = square()
    graph["features"][5]["properties"] = {"id": 1, "startid": 1, "endid": 2}
    graph["features"][7]["properties"]["metadata"] = {"door_width": 0.9}
    graph["features"][4]["properties"]["metadata"] = {"door_width": 0.7}
    values = page(own_plugins)["route_server"]
    values["graph_filepath"] = str(written(own_plugins, graph))
    robot = started(ROUTE_SERVER, settle=0.2, route_server=values)
    request = ComputeAndTrackRoute.Goal(start_id=0, goal_id=2)
    goal = robot.send(ComputeAndTrackRoute, "compute_and_track_route", request)
    robot.run(0.1)
    assert goal.feedback[-1].route.route_cost == 11.0, "by the wide door; the narrow is closed"
    robot.run(2.1)
    assert goal.result.error_code == ComputeAndTrackRoute.Result.NO_VALID_ROUTE


@pytest.mark.parametrize(("line", "succeeds"), [(-1.0, True), (1.0, False)])
def test_a_node_of_trees(
    robot: PlayedRobot, own_plugins: Path, line: float, succeeds: bool
) -> None:
    (own_plugins / "east.xml").write_text(IS_EAST.format(line), encoding="utf-8")
    pose = pose_stamped(SE2(1.0, 0.0), "map", 0.0)
    goal = NavigateToPose.Goal(pose=pose, behavior_tree="east.xml")
    sent = robot.send(NavigateToPose, "navigate_to_pose", goal)
    robot.run_until_done(sent, 3.0)
    assert (sent.status == SUCCEEDED) == succeeds


def test_missing_modules_are_named(own_plugins: Path, capfd: pytest.CaptureFixture[str]) -> None:
    values = page(own_plugins)
    built_in = ["nav2_wait_action_bt_node", "opennav_dock_action_bt_node"]
    values["bt_navigator"]["plugin_lib_names"] = [*built_in, "your_trees"]
    (own_plugins / "east.xml").write_text(IS_EAST.format(0.0), encoding="utf-8")
    robot = made(values)
    log = capfd.readouterr().err
    assert "'your_trees' is no Python module with nodes of trees" in log
    assert not any(name in log for name in built_in)
    pose = pose_stamped(SE2(1.0, 0.0), "map", 0.0)
    goal = NavigateToPose.Goal(pose=pose, behavior_tree="east.xml")
    sent = robot.send(NavigateToPose, "navigate_to_pose", goal)
    robot.fail(sent, 3.0, 0, "there is no node 'IsEast'")
