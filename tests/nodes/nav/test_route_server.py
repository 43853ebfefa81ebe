"""route_server: routes by numbers and by poses, progress on them, edges closed meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputeAndTrackRoute, ComputeRoute
from nav2_msgs.msg import EdgeCost
from nav2_msgs.srv import DynamicEdges, SetRouteGraph
from std_srvs.srv import Trigger

from arjuna_core.ros.convert import pose_stamped, poses_from_path
from arjuna_core.se2 import SE2
from bringup.stack import ROUTE_SERVER
from tests.helpers.nav.navigation import ABORTED, SUCCEEDED, Goal, PlayedRobot, started
from tests.helpers.nav.routes import written

Code = ComputeRoute.Result


@pytest.fixture
def robot(tmp_path: Path) -> PlayedRobot:
    values = {"graph_filepath": str(written(tmp_path)), "graphs_folder": str(tmp_path)}
    return started(ROUTE_SERVER, settle=0.2, route_server=values)


def ask(robot: PlayedRobot, track: bool = False, **fields: Any) -> Goal:
    if track:
        goal = ComputeAndTrackRoute.Goal(**fields)
        return robot.send(ComputeAndTrackRoute, "compute_and_track_route", goal)
    return robot.send(ComputeRoute, "compute_route", ComputeRoute.Goal(**fields))


def pose(x: float, y: float) -> PoseStamped:
    return pose_stamped(SE2(x, y), "map", 0.0)


def test_a_route_by_numbers_and_by_poses(robot: PlayedRobot) -> None:
    by_numbers = ask(robot, start_id=0, goal_id=2)
    assert by_numbers.status == SUCCEEDED
    route = by_numbers.result.route
    assert [node.nodeid for node in route.nodes] == [0, 3, 2]
    assert [edge.edgeid for edge in route.edges] == [3, 4]
    assert (route.route_cost, route.header.frame_id) == (8.0, "map")
    assert poses_from_path(by_numbers.result.path)[-1, :2] == pytest.approx((4.0, 4.0))
    by_poses = ask(robot, use_poses=True, use_start=True, start=pose(3.9, 0.2), goal=pose(4.2, 4.3))
    assert [node.nodeid for node in by_poses.result.route.nodes] == [2]
    robot.pose = SE2(-0.5, -0.5)
    robot.run(0.1)
    from_here = ask(robot, use_poses=True, goal=pose(4.2, 4.3))
    assert [node.nodeid for node in from_here.result.route.nodes] == [0, 3, 2]


@pytest.mark.parametrize("track", [False, True])
def test_says_why_there_is_no_route(robot: PlayedRobot, track: bool) -> None:
    cases = (
        (Code.INDETERMINANT_NODES_ON_GRAPH, {"start_id": 0, "goal_id": 9}),
        (Code.NO_VALID_ROUTE, {"start_id": 2, "goal_id": 0}),
        (Code.TF_ERROR, {"use_poses": True, "goal": pose_stamped(SE2(), "moon", 0.0)}),
    )
    for code, fields in cases:
        goal = ask(robot, track, **fields)
        assert (goal.status, goal.result.error_code) == (ABORTED, code)


@pytest.mark.parametrize("name", ["none", "/dev/zero", "../graph.geojson", "http://["])
def test_a_graph_that_cannot_be_read_leaves_the_last(
    robot: PlayedRobot, tmp_path: Path, name: str
) -> None:
    wrong = SetRouteGraph.Request(graph_filepath=name)
    assert not robot.bench.call(SetRouteGraph, "route_server/set_route_graph", wrong).success
    assert ask(robot, start_id=0, goal_id=2).status == SUCCEEDED
    right = SetRouteGraph.Request(graph_filepath=str(written(tmp_path)))
    assert robot.bench.call(SetRouteGraph, "route_server/set_route_graph", right).success


def test_progress_is_sent_until_the_last_node(robot: PlayedRobot) -> None:
    goal = ask(robot, True, start_id=0, goal_id=2)
    for x, y in ((0.0, 0.1), (0.1, 3.9), (2.0, 4.0), (3.5, 4.0)):
        robot.pose = SE2(x, y)
        robot.run(0.1)
    assert goal.status == SUCCEEDED
    progress = [(one.last_node_id, one.next_node_id, one.current_edge_id) for one in goal.feedback]
    assert progress == [(0, 0, 0), (0, 3, 3), (3, 2, 4), (2, 0, 0)]
    assert goal.result.execution_duration.nanosec > 0


def test_a_closed_edge_ahead_leads_to_another_route(robot: PlayedRobot) -> None:
    edges = "route_server/DynamicEdgesScorer/adjust_edges"
    assert not robot.bench.call(
        DynamicEdges, edges, DynamicEdges.Request(closed_edges=[77])
    ).success
    robot.pose = SE2(-0.5, -0.5)
    robot.run(0.1)
    goal = ask(robot, True, start_id=0, goal_id=2)
    assert robot.bench.call(DynamicEdges, edges, DynamicEdges.Request(closed_edges=[4])).success
    robot.run(0.1)
    assert goal.feedback[-1].rerouted
    assert [node.nodeid for node in goal.feedback[-1].route.nodes] == [0, 1, 2]
    costly = DynamicEdges.Request(opened_edges=[4], adjust_edges=[EdgeCost(edgeid=0, cost=90.0)])
    assert robot.bench.call(DynamicEdges, edges, costly).success
    assert robot.bench.call(
        Trigger, "route_server/ReroutingService/reroute", Trigger.Request()
    ).success
    robot.run(0.1)
    assert [node.nodeid for node in goal.feedback[-1].route.nodes] == [0, 3, 2]
    shut = DynamicEdges.Request(closed_edges=[3, 4, 0])
    assert robot.bench.call(DynamicEdges, edges, shut).success
    robot.run(0.1)
    assert (goal.status, goal.result.error_code) == (ABORTED, Code.NO_VALID_ROUTE)
