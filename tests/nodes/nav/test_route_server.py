"""route_server: routes by numbers and by poses, progress on them, edges closed meanwhile."""

from __future__ import annotations

import sys
import types
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputeAndTrackRoute, ComputeRoute
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate, EdgeCost, SpeedLimit
from nav2_msgs.srv import DynamicEdges, SetRouteGraph
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.config import param
from arjuna_core.grid import GridFrame
from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, poses_from_path, transform_msg
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import Costmap
from arjuna_nav.nodes.costmap.messages import costmap_raw_msg, costmap_raw_update_msg
from bringup.stack import ROUTE_SERVER
from tests.helpers.nav.navigation import ABORTED, SUCCEEDED, Goal, PlayedRobot, started
from tests.helpers.nav.routes import square, written

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


def test_the_graph_is_shown_and_a_new_one_in_its_place(robot: PlayedRobot, tmp_path: Path) -> None:
    seen = robot.bench.latched(MarkerArray, "/route_graph")
    robot.run(0.1)
    shown = {one.ns: one for one in seen[-1].markers}
    assert [len(shown[f"route_graph_{kind}"].points) for kind in ("nodes", "edges")] == [4, 10]
    texts = [one.text for one in seen[-1].markers if one.ns == "route_graph_edge_ids"]
    assert texts == ["0", "1", "2", "3", "4"]
    content = square()
    content["features"] = [content["features"][k] for k in (0, 1, EDGES)]
    request = SetRouteGraph.Request(graph_filepath=str(written(tmp_path, content)))
    assert robot.bench.call(SetRouteGraph, "/route_server/set_route_graph", request).success
    robot.run(0.1)
    assert seen[-1].markers[0].action == Marker.DELETEALL
    assert len(seen[-1].markers[1].points) == 2


@pytest.mark.parametrize(("search", "nodes"), [(True, [1, 2]), (False, [0, 3, 2])])
def test_a_route_begins_where_no_obstacle_is_between(
    tmp_path: Path, search: bool, nodes: list[int]
) -> None:
    robot = serving(tmp_path, costmap_topic="costs", enable_nn_search=search)
    send_costmap(robot, "/costs", 1.0, 0.0)
    ends = {"start": pose(2.0, 0.0), "goal": pose(4.0, 4.0)}
    found = ask(robot, use_poses=True, use_start=True, **ends)
    assert nodes_of(found.result.route) == nodes


@pytest.mark.parametrize(("most", "code"), [(0, Code.NONE), (1, Code.TIMEOUT)])
def test_a_search_has_as_many_iterations_as_are_given(tmp_path: Path, most: int, code: int) -> None:
    goal = ask(serving(tmp_path, max_iterations=most), start_id=0, goal_id=1)
    assert goal.result.error_code == code


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


def test_a_graph_that_cannot_be_read_leaves_the_last(robot: PlayedRobot, tmp_path: Path) -> None:
    for name in ("none", "/dev/zero", "../graph.geojson", "http://["):
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


Tracked = ComputeAndTrackRoute.Result
EDGES = 4  # features before the edges in the square
T_MAP_SHIFTED = SE2(-3.0, 1.0)


def serving(tmp_path: Path, content: dict[str, Any] | None = None, **values: Any) -> PlayedRobot:
    path = {"graph_filepath": str(written(tmp_path, content))}
    return started(ROUTE_SERVER, settle=0.2, route_server={**path, **values})


def asking(changes: dict[int, dict[str, Any]]) -> dict[str, Any]:
    """Return the square with more in the properties of features."""
    content = square()
    for k, more in changes.items():
        content["features"][k]["properties"] |= more
    return content


def test_a_graph_of_another_frame_is_read_once_the_frame_is_known(tmp_path: Path) -> None:
    robot = serving(tmp_path, asking({k: {"frame": "site"} for k in range(4)}))
    assert ask(robot, start_id=0, goal_id=2).result.error_code == Code.NO_VALID_GRAPH
    robot = serving(tmp_path, asking({k: {"frame": "odom"} for k in range(4)}))
    assert ask(robot, start_id=0, goal_id=2).status == SUCCEEDED


def nodes_of(route: Any) -> list[int]:
    return [node.nodeid for node in route.nodes]


def drive(robot: PlayedRobot, *points: tuple[float, float]) -> None:
    for x, y in points:
        robot.pose = SE2(x, y)
        robot.run(0.1)


def send_costmap(robot: PlayedRobot, topic: str, x: float, y: float, update: bool = False) -> None:
    """Publish a free costmap with an obstacle of 1 m at a point of the map, in a frame of its own.

    Args:
        update: Whether the obstacle comes as an update.
    """
    fixed = TFMessage(transforms=[transform_msg(T_MAP_SHIFTED, "map", "shifted", robot.now)])
    robot.bench.publish(TFMessage, "/tf_static", fixed, qos.TF_STATIC)
    frame = GridFrame(0.5, 16, 16, T_MAP_SHIFTED.inverse() @ SE2(-1.0, -1.0))
    free = Costmap(frame, np.zeros(frame.shape, np.uint8))
    blocked = Costmap(frame, free.data.copy())
    row, column = (int((value + 1.0) / 0.5) for value in (y, x))
    window = slice(row - 1, row + 1), slice(column - 1, column + 1)
    blocked.data[window] = 254
    message = costmap_raw_msg(free if update else blocked, "shifted", robot.now)
    robot.bench.publish(CostmapMsg, topic, message, qos.LATCHED)
    if update:
        part = costmap_raw_update_msg(blocked, window, "shifted", robot.now)
        robot.bench.publish(CostmapUpdate, f"{topic}_updates", part, qos.LATCHED)


def test_a_cost_of_the_service_adds_to_the_others_and_has_the_plugins_name(tmp_path: Path) -> None:
    content = asking({EDGES + 1: {"overridable": True}, EDGES: {"metadata": {}}})
    robot = serving(tmp_path, content, edge_cost_functions=["Length", "Town"], **NAMED)
    costs = [EdgeCost(edgeid=k, cost=c) for k, c in ((0, 1.0), (1, 0.0), (3, 2.0))]
    request = DynamicEdges.Request(adjust_edges=costs)
    assert robot.bench.call(DynamicEdges, "route_server/Town/adjust_edges", request).success
    route = ask(robot, start_id=0, goal_id=2).result.route
    assert (nodes_of(route), route.route_cost) == ([0, 1, 2], 17.0)


NAMED = {
    "Length": {"plugin": "nav2_route::DistanceScorer", "weight": 2.0},
    "Town": {"plugin": "nav2_route::DynamicEdgesScorer"},
}


@pytest.mark.parametrize("update", [False, True])
def test_an_obstacle_on_a_costmap_closes_its_edge(tmp_path: Path, update: bool) -> None:
    names = ["DistanceScorer", "CostmapScorer"]
    robot = serving(tmp_path, edge_cost_functions=names, CostmapScorer={"costmap_topic": "costs"})
    without = ask(robot, start_id=0, goal_id=2)
    assert (without.status, without.result.error_code) == (ABORTED, Code.NO_VALID_ROUTE)
    send_costmap(robot, "/costs", 0.0, 2.0, update)
    assert nodes_of(ask(robot, start_id=0, goal_id=2).result.route) == [0, 1, 2]


def test_a_scorer_of_headings_needs_poses(tmp_path: Path) -> None:
    values = {"use_orientation_threshold": True}
    name = "StartPoseOrientationScorer"
    robot = serving(tmp_path, edge_cost_functions=["DistanceScorer", name], **{name: values})
    by_nodes = ask(robot, start_id=0, goal_id=2)
    assert by_nodes.result.error_code == Code.INVALID_EDGE_SCORER_USE
    for heading, nodes in ((-0.2, [0, 1, 2]), (1.8, [0, 3, 2])):
        start, goal = (pose_stamped(pose, "map", 0.0) for pose in (SE2(0, 0, heading), SE2(4, 4)))
        by_poses = ask(robot, use_poses=True, use_start=True, start=start, goal=goal)
        assert nodes_of(by_poses.result.route) == nodes


def test_the_speed_limit_of_an_edge_is_published_and_lifted_at_the_end(tmp_path: Path) -> None:
    changes: dict[int, dict[str, Any]] = {
        EDGES + 3: {"metadata": {"slow": 40}},
        EDGES + 4: {"metadata": {"slow": 0.4}},
    }
    own = {"speed_tag": "slow", "speed_limit_topic": "limits"}
    robot = serving(tmp_path, asking(changes), AdjustSpeedLimit=own)
    limits = robot.bench.collect(SpeedLimit, "/limits", qos.DEFAULT)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.1), (0.2, 3.9), (3.5, 4.0))
    assert goal.status == SUCCEEDED
    assert [(one.percentage, one.speed_limit) for one in limits] == [(True, 40.0), (True, 100.0)]
    assert [one.operations_triggered for one in goal.feedback[1:]] == [
        ["AdjustSpeedLimit"],
        [],
        ["AdjustSpeedLimit"],
    ]


def test_a_tracked_route_is_rerouted_by_the_plugins_name(tmp_path: Path) -> None:
    again = {"plugin": "nav2_route::ReroutingService"}
    robot = serving(tmp_path, operations=["Again"], Again=again)
    service, request = "route_server/Again/reroute", Trigger.Request()
    assert not robot.bench.call(Trigger, service, request).success
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.5))
    costly = DynamicEdges.Request(adjust_edges=[EdgeCost(edgeid=4, cost=90.0)])
    edges = "route_server/DynamicEdgesScorer/adjust_edges"
    assert robot.bench.call(DynamicEdges, edges, costly).success
    robot.run(0.1)
    assert goal.feedback[0].rerouted  # so a program passes the first route on, as each later one
    assert not any(one.rerouted for one in goal.feedback[1:])
    assert robot.bench.call(Trigger, service, request).success
    robot.run(0.1)
    assert [bool(one.rerouted) for one in goal.feedback].count(True) == 2
    assert ["Again"] in [one.operations_triggered for one in goal.feedback]
    assert nodes_of(goal.feedback[-1].route) == [0, 1, 2]


MONITOR = ["ReroutingService", "CollisionMonitor"]


@pytest.mark.parametrize(
    ("obstacle", "nodes"),
    [((0.0, 3.0), [0, 1, 2]), ((2.0, 4.0), [0, 1, 2]), ((4.0, 2.0), [0, 3, 2])],
)
def test_a_route_that_is_blocked_ahead_is_left(
    tmp_path: Path, obstacle: tuple[float, float], nodes: list[int]
) -> None:
    values = {"max_collision_dist": 6.0, "costmap_topic": "costs"}
    robot = serving(tmp_path, operations=MONITOR, CollisionMonitor=values)
    send_costmap(robot, "/costs", *obstacle)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.5))
    robot.run(1.0)
    assert any(one.rerouted for one in goal.feedback[1:]) == (nodes == [0, 1, 2])
    assert nodes_of(goal.feedback[-1].route) == nodes


def test_a_route_that_is_blocked_behind_its_forks_fails(tmp_path: Path) -> None:
    robot = serving(tmp_path, operations=MONITOR, CollisionMonitor={"costmap_topic": "costs"})
    send_costmap(robot, "/costs", 5.0, 0.0)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.5), (0.2, 3.9))
    send_costmap(robot, "/costs", 2.0, 4.0)
    robot.run(1.0)
    assert (goal.status, goal.result.error_code) == (ABORTED, Code.NO_VALID_ROUTE)


@pytest.mark.parametrize(("aggregate", "kept"), [(False, [3, 2]), (True, [0, 1, 2])])
def test_blocked_edges_may_be_gathered(tmp_path: Path, aggregate: bool, kept: list[int]) -> None:
    values = {"max_collision_dist": 6.0, "costmap_topic": "costs", "rate": 0.1}
    robot = serving(
        tmp_path, operations=MONITOR, CollisionMonitor=values, aggregate_blocked_ids=aggregate
    )
    send_costmap(robot, "/costs", 2.0, 4.0)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.5))
    assert nodes_of(goal.feedback[-1].route) == [0, 1, 2]
    service = "route_server/ReroutingService/reroute"
    assert robot.bench.call(Trigger, service, Trigger.Request()).success
    robot.run(0.1)
    assert nodes_of(goal.feedback[-1].route) == kept


def test_the_route_continues_along_the_current_edge(tmp_path: Path) -> None:
    content = asking({EDGES + 1: {"overridable": True}})
    content["features"].append(
        {
            "type": "Feature",
            "properties": {"id": 9, "startid": 3, "endid": 1},
            "geometry": {"type": "LineString", "coordinates": []},
        }
    )
    robot = serving(tmp_path, content)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.5), (0.0, 1.0))
    request = DynamicEdges.Request(closed_edges=[0, 4])
    edges = "route_server/DynamicEdgesScorer/adjust_edges"
    assert robot.bench.call(DynamicEdges, edges, request).success
    robot.run(0.1)
    last = goal.feedback[-1]
    assert (last.rerouted, nodes_of(last.route)) == (True, [3, 1, 2])
    assert (last.last_node_id, last.current_edge_id, last.next_node_id) == (0, 3, 3)


BELL = {"type": "Bell", "trigger": "NODE", "metadata": {"service_name": "bell"}}
TRIGGER = {"plugin": "nav2_route::TriggerEvent", "service_name": "doors"}


def serve(robot: PlayedRobot, *names: str) -> list[str]:
    """Serve triggers; return a list that grows with the name of each that is called."""
    called: list[str] = []
    for name in names:

        def answer(request: Any, response: Any, name: str = name) -> Any:
            called.append(name)
            response.success = False  # the route goes on all the same
            return response

        robot.bench.node.create_service(Trigger, f"/{name}", answer)
    robot.bench.process.drain()
    return called


def test_services_are_called_where_the_graph_asks_for_it(tmp_path: Path) -> None:
    door = {"type": "Bell", "trigger": "ON_EXIT"}
    content = asking({0: {"operations": {"a": BELL}}, EDGES + 3: {"operations": {"b": door}}})
    robot = serving(tmp_path, content, operations=["Bell"], Bell=TRIGGER)
    called = serve(robot, "bell", "doors")
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.1))
    assert called == ["bell"]
    drive(robot, (0.2, 3.9), (3.5, 4.0))
    assert (goal.status, called) == (SUCCEEDED, ["bell", "doors"])
    assert [one.operations_triggered for one in goal.feedback[1:]] == [["Bell"], ["Bell"], []]


def test_a_route_does_not_end_before_its_service_has_answered(tmp_path: Path) -> None:
    content = asking({2: {"operations": {"a": BELL}}})
    patient = {**TRIGGER, "service_timeout": 2.0}
    robot = serving(tmp_path, content, operations=["Bell"], Bell=patient)
    goal = ask(robot, True, start_id=2, goal_id=2)
    drive(robot, (4.0, 4.0))
    robot.run(1.0)
    assert not goal.done
    called = serve(robot, "bell")
    robot.run(0.1)
    assert (goal.status, called) == (SUCCEEDED, ["bell"])


def test_a_service_of_the_last_goal_does_not_fail_the_next(tmp_path: Path) -> None:
    content = asking({0: {"operations": {"a": BELL}}})
    robot = serving(tmp_path, content, operations=["Bell"], Bell=TRIGGER)
    ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.1))
    following = ask(robot, True, start_id=3, goal_id=2)
    robot.run(1.0)
    assert not following.done


@pytest.mark.parametrize(
    ("operation", "values"),
    [
        (BELL, {"operations": ["Bell"], "Bell": TRIGGER}),
        (
            {**BELL, "metadata": {}},
            {"operations": ["Bell"], "Bell": {**TRIGGER, "service_name": ""}},
        ),
        (BELL, {}),
    ],
)
def test_an_operation_that_cannot_be_performed_fails_the_goal(
    tmp_path: Path, operation: dict[str, Any], values: dict[str, Any]
) -> None:
    robot = serving(tmp_path, asking({0: {"operations": {"a": operation}}}), **values)
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.1))
    robot.run(0.6)
    assert (goal.status, goal.result.error_code) == (ABORTED, Tracked.OPERATION_FAILED)
    later = ask(robot, start_id=0, goal_id=2)
    assert later.status == SUCCEEDED


@dataclass(frozen=True)
class Config:
    limit: float = param(0.0, "Where it raises.")


class Own:
    """A scorer and an operation that raises, as a user might write it."""

    Config = Config

    def __init__(self, config: Any, name: str, node: Any) -> None:
        self.config = config

    def score(self, edge: Any, request: Any) -> float:
        return float(edge.metadata["height"])

    def perform(self, event: Any) -> None:
        if event.pose.x > self.config.limit:
            raise KeyError("no bell")


@pytest.mark.parametrize(
    ("values", "code", "reason"),
    [
        ({"edge_cost_functions": ["Own"]}, Code.INVALID_EDGE_SCORER_USE, "KeyError: 'height'"),
        ({"operations": ["Own"]}, Tracked.OPERATION_FAILED, "KeyError: 'no bell'"),
    ],
)
def test_what_raises_fails_its_goal_with_its_last_line_and_not_the_server(
    tmp_path: Path,
    values: dict[str, Any],
    code: int,
    reason: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    module = types.ModuleType("own_route_plugins")
    vars(module).update(Own=Own)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    own = {"plugin": "own_route_plugins:Own", "limit": 0.5}
    robot = serving(tmp_path, **values, Own=own)
    robot.bench.process.guard.strict = False
    goal = ask(robot, True, start_id=0, goal_id=2)
    drive(robot, (0.0, 0.1), (1.0, 0.1))
    assert (goal.status, goal.result.error_code) == (ABORTED, code)
    assert f"compute_and_track_route: goal aborted: {reason}" in "".join(capfd.readouterr())
    drive(robot, (0.0, 0.1))
    ask(robot, True, start_id=2, goal_id=2)
    robot.run(0.1)
    assert robot.nodes["route_server"].tracker is not None, "it serves the next"


def test_a_start_far_along_an_edge_is_not_cut_off_where_that_is_asked(tmp_path: Path) -> None:
    start, goal = (pose_stamped(SE2(*at), "map", 0.0) for at in ((3.9, 0.2), (4.2, 4.3)))
    robot = serving(tmp_path, min_prune_dist_from_start=9.0)
    route = ask(robot, use_poses=True, use_start=True, start=start, goal=goal).result.route
    assert nodes_of(route) == [1, 2]
