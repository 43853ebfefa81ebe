"""The requests of nodes to servers, and the answers that they write."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Answer, Ask, TreeState
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
PATH = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


def test_what_is_cancelled_succeeds() -> None:
    play = Play(
        '<PipelineSequence><Fallback><Inverter><PathExpiringTimer seconds="0.15"/></Inverter>'
        "<CancelControl/></Fallback>"
        '<FollowPath path="{path}"/></PipelineSequence>',
        path=PATH,
    )
    assert [play.tick() for _ in range(2)] == [RUNNING, RUNNING]
    following = play.open["FollowPath"]
    assert play.tick() is SUCCESS
    assert play.withdrawn == [following]


@pytest.mark.parametrize(
    ("given", "server"),
    [("", "turn"), ("server_name='turn'", "turn"), ("server_name='spin'", None)],
)
def test_a_cancel_is_of_the_server_that_it_names(given: str, server: str | None) -> None:
    play = Play(
        "<Parallel success_count='2'><Spin server_name='turn'/>"
        f"<Sequence><Wait/><CancelSpin {given}/></Sequence></Parallel>"
    )
    play.tick()
    spinning = play.open["Spin"]
    play.tick(Wait=True)
    assert play.withdrawn == ([spinning] if server else [])


def test_codes_and_messages_are_written() -> None:
    play = Play('<FollowPath path="{path}" error_code_id="{code}" error_msg="{why}"/>', path=PATH)
    play.tick()
    assert play.tick(FollowPath=Answer(False, 105, "stuck")) is FAILURE
    assert (play.get("code"), play.get("why")) == (105, "stuck")
    play.tick()
    assert play.tick(FollowPath=Answer(True, 105, "stuck before")) is SUCCESS
    assert (play.get("code"), play.get("why")) == (0, "")


@pytest.mark.parametrize(
    ("node", "server", "fields"),
    [
        ("ComputeRoute start_id='3' goal_id='7'", "compute_route", {"start_id": 3, "goal_id": 7}),
        (
            "ComputeRoute goal='{there}' use_poses='true'",
            "compute_route",
            {"goal": SE2(2.0), "use_poses": True},
        ),
        (
            "ComputeRoute start='{here}' use_start='1' goal='{there}' use_poses='1'",
            "compute_route",
            {"start": SE2(1.0), "use_start": True, "goal": SE2(2.0), "use_poses": True},
        ),
        (
            "ComputeAndTrackRoute goal_id='4' server_name='other'",
            "other",
            {"goal_id": 4},
        ),
        (
            "NavigateToPose goal='{there}' behavior_tree='a.xml'",
            "navigate_to_pose",
            {"pose": SE2(2.0), "behavior_tree": "a.xml"},
        ),
        (
            "NavigateToPose goal='0;map;1.0;2;0;0;0;0;1'",
            "navigate_to_pose",
            {"pose": SE2(1.0, 2.0), "behavior_tree": ""},
        ),
        (
            "NavigateThroughPoses goals='0;map;1;0;0;0;0;0;1;0;map;2;0;0;0;0;0;1'",
            "navigate_through_poses",
            {"poses": (SE2(1.0), SE2(2.0)), "behavior_tree": ""},
        ),
        (
            "NavigateThroughPoses goals='{all}'",
            "navigate_through_poses",
            {"poses": (SE2(1.0), SE2(2.0)), "behavior_tree": ""},
        ),
    ],
)
def test_what_servers_are_asked(node: str, server: str, fields: dict[str, Any]) -> None:
    here, there = SE2(1.0), SE2(2.0)
    play = Play(f"<{node}/>", here=here, there=there, all=(here, there))
    (ask,) = play.tree.tick(TreeState(0.1))[1]
    assert isinstance(ask, Ask)
    assert (ask.kind, ask.server) == (node.split()[0], server)
    usual = {"use_start": False, "use_poses": False} if "Compute" in node else {}
    assert dict(ask.fields) == {**usual, **fields}
    assert ask.feedback == node.startswith("ComputeAndTrack")


def test_a_route_is_written() -> None:
    play = Play('<ComputeRoute route="{r}" path="{p}" planning_time="{t}" error_code_id="{e}"/>')
    play.tick()
    path, nodes = np.zeros((3, 3)), (SE2(), SE2(1.0))
    found = Answer(True, values={"route": nodes, "path": path, "planning_time": 0.2})
    assert play.tick(ComputeRoute=found) is SUCCESS
    assert (play.get("r"), play.get("t"), play.get("e")) == (nodes, 0.2, 0)
    assert play.get("p") is path
    play.tick()
    assert play.tick(ComputeRoute=Answer(False, 405)) is FAILURE
    assert play.get("e") == 405


def test_the_progress_on_a_route_is_written_as_it_comes() -> None:
    play = Play(
        '<ComputeAndTrackRoute last_node_id="{last}" next_node_id="{next}" path="{p}"'
        ' current_edge_id="{edge}" rerouted="{new}" execution_time="{took}"/>'
    )
    assert play.tick() is RUNNING
    first, second = np.zeros((2, 3)), np.ones((2, 3))
    for last, path, new in ((4, first, False), (5, second, True)):
        nodes = {"last_node_id": last, "next_node_id": last + 1, "current_edge_id": 9}
        play.feedback = {"ComputeAndTrackRoute": {**nodes, "path": path, "rerouted": new}}
        assert play.tick() is RUNNING
        assert [play.get(name) for name in ("last", "next", "edge", "new")] == [
            *(last, last + 1, 9),
            new,
        ]
        assert play.get("p") is path
    play.tree.blackboard.set("p", first)
    assert play.tick() is RUNNING
    assert play.get("p") is first, "feedback is written once"
    done = Answer(True, values={"execution_duration": 3.5})
    assert play.tick(ComputeAndTrackRoute=done) is SUCCESS
    assert play.get("took") == 3.5


@pytest.mark.parametrize("node", ["ComputeRoute", "ComputeAndTrackRoute"])
def test_a_goal_that_changes_is_asked_for_again(node: str) -> None:
    play = Play(f'<{node} goal="{{goal}}" use_poses="true" route="{{r}}"/>', goal=SE2(1.0))
    play.tick()
    first = play.open[node]
    assert play.tick() is RUNNING
    assert play.open[node] == first
    play.tree.blackboard.set("goal", SE2(2.0))
    play.tick()
    assert play.open[node] != first
    assert play.tick(**{node: True}) is SUCCESS


def test_tracking_is_cancelled_by_another_node() -> None:
    play = Play(
        '<Parallel success_count="2"><ComputeAndTrackRoute goal_id="2"/>'
        "<Sequence><Wait/><CancelComputeAndTrackRoute/></Sequence></Parallel>"
    )
    play.tick()
    tracking = play.open["ComputeAndTrackRoute"]
    play.tick(Wait=True)
    assert play.withdrawn == [tracking]
    assert play.tick() is SUCCESS


def asked(xml: str) -> Ask:
    """Return what the one node of a tree asks in its first tick."""
    _, commands = Play(xml).tree.tick(TreeState(0.1))
    (ask,) = [command for command in commands if isinstance(command, Ask)]
    return ask


BACK = {"target": 0.15, "speed": 0.025, "time_allowance": 10.0}
DOCK = {"use_dock_id": True, "max_staging_time": 1000.0, "navigate_to_staging_pose": True,
        "dock_id": "", "dock_type": ""}  # fmt: skip


@pytest.mark.parametrize(
    ("node", "server", "fields"),
    [
        ("Spin", "spin", {"target_yaw": 1.57, "time_allowance": 10.0}),
        ("Spin spin_dist='-0.5'", "spin", {"target_yaw": -0.5, "time_allowance": 10.0}),
        ("Spin server_name='turn'", "turn", {"target_yaw": 1.57, "time_allowance": 10.0}),
        ("Wait", "wait", {"time": 1.0}),
        ("Wait wait_duration='3'", "wait", {"time": 3.0}),
        ("BackUp", "backup", BACK),
        ("BackUp backup_dist='0.3'", "backup", {**BACK, "target": 0.3}),
        ("DriveOnHeading", "drive_on_heading", BACK),
        ("DriveOnHeading speed='0.2'", "drive_on_heading", {**BACK, "speed": 0.2}),
        ("AssistedTeleop", "assisted_teleop", {"time_allowance": 10.0}),
        ("DockRobot", "dock_robot", DOCK),
        ("DockRobot use_dock_id='false'", "dock_robot", {**DOCK, "use_dock_id": False}),
    ],
)
def test_what_is_not_said_is_nav2s(node: str, server: str, fields: dict[str, Any]) -> None:
    ask = asked(f"<{node}/>")
    assert (ask.kind, ask.server) == (node.split()[0], server)
    assert dict(ask.fields) == fields


def test_a_plan_to_a_goal_that_was_replaced_is_asked_for_again() -> None:
    path = np.zeros((2, 3))
    play = Play('<ComputePathToPose goal="{goal}" path="{path}"/>', goal=SE2(1.0, 0.0))
    play.tick()
    older = play.open["ComputePathToPose"]
    play.tree.blackboard.set("goal", SE2(2.0, 0.0))
    found = Answer(True, values={"path": path})
    assert play.tick(ComputePathToPose=found) is Status.RUNNING
    assert play.get("path") is None
    assert play.open["ComputePathToPose"] != older
    assert play.tick(ComputePathToPose=found) is Status.SUCCESS
    assert play.get("path") is path


@pytest.mark.parametrize(
    ("node", "counted"),
    [
        ("<Spin/>", 1),
        ('<Spin is_recovery="false"/>', None),
        ("<Wait/>", 1),
        ("<BackUp/>", 1),
        ("<AssistedTeleop/>", None),
        ('<AssistedTeleop is_recovery="true"/>', 1),
        ("<DriveOnHeading/>", None),
        ('<ClearEntireCostmap service_name="clear"/>', 1),
        ('<ClearEntireCostmap service_name="clear" is_recovery="false"/>', None),
        ("<ReinitializeGlobalLocalization/>", 1),
        ('<FollowPath path="{path}"/>', None),
    ],
)
def test_feedback_counts_what_is_a_recovery(node: str, counted: int | None) -> None:
    play = Play(node, path=np.zeros((2, 3)))
    play.tick()
    assert play.get("number_recoveries") == counted
    play.tick()
    assert play.get("number_recoveries") == counted, "once, though it runs on"


def test_a_path_is_followed_again_only_where_something_has_changed() -> None:
    path = np.zeros((2, 3))
    play = Play('<FollowPath path="{path}" controller_id="{by}"/>', path=path, by="First")
    play.tick()
    first = play.open["FollowPath"]
    play.tick()
    assert play.open["FollowPath"] == first
    play.tree.blackboard.set("by", "Second")
    play.tick()
    second = play.open["FollowPath"]
    assert second != first
    play.tree.blackboard.set("path", path.copy())
    play.tick()
    assert play.open["FollowPath"] not in (first, second)


def test_a_plan_begins_at_its_start_unless_use_start_is_false() -> None:
    xml = '<ComputePathToPose goal="{goal}" start="{start}" path="{p}" use_start="USE"/>'
    for use, fields in (("true", {"start": SE2(1.0), "use_start": True}), ("false", {})):
        play = Play(xml.replace("USE", use), goal=SE2(3.0), start=SE2(1.0))
        _, commands = play.tree.tick(TreeState(0.1))
        (ask,) = [command for command in commands if isinstance(command, Ask)]
        expected = {"goal": SE2(3.0), "planner_id": "", "use_start": False, **fields}
        assert dict(ask.fields) == expected


def test_a_smoothed_path_is_written_where_smoothing_succeeded() -> None:
    path = np.ones((2, 3))
    for succeeded in (True, False):
        play = Play(
            '<SmoothPath unsmoothed_path="{rough}" smoothed_path="{smooth}"/>', rough=path[:1]
        )
        play.tick()
        status = play.tick(SmoothPath=Answer(succeeded, values={"path": path}))
        assert (status is Status.SUCCESS) is succeeded
        assert (play.get("smooth") is path) is succeeded


def test_goals_in_obstacles_are_left_out_and_not_asked_about_again() -> None:
    near, wall, unknown = SE2(1.0), SE2(2.0), SE2(3.0)
    play = Play(
        '<ReactiveSequence><RemoveInCollisionGoals input_goals="{goals}" output_goals="{goals}"/>'
        '<ComputePathThroughPoses goals="{goals}" path="{path}"/></ReactiveSequence>',
        goals=(near, wall, unknown),
    )
    play.tick()
    for cost in (10.0, 254.0, 255.0):
        assert play.tick(GetCost=Answer(True, values={"cost": cost})) is RUNNING
    assert play.get("goals") == (near, unknown)
    assert [play.tick() for _ in range(3)] == [RUNNING] * 3
    assert (set(play.open), play.withdrawn) == ({"ComputePathThroughPoses"}, [])


@pytest.mark.parametrize(
    ("ports", "cost", "status"),
    [("", 254.0, SUCCESS), ("", 253.0, FAILURE), ("", 255.0, FAILURE),
     ("consider_unknown_as_obstacle='true'", 255.0, SUCCESS),
     ("cost_threshold='100'", 120.0, SUCCESS)],
)  # fmt: skip
def test_a_pose_is_occupied_by_its_cost(ports: str, cost: float, status: Status) -> None:
    play = Play(f"<IsPoseOccupied pose='{{goal}}' {ports}/>", goal=SE2(1.0, 2.0, 0.5))
    assert play.tick() is RUNNING
    assert play.tick(GetCost=Answer(True, values={"cost": cost})) is status


@pytest.mark.parametrize("name", ["IsPathValid", "ValidatePath"])
@pytest.mark.parametrize(
    ("ports", "count"),
    [("", 21), ("max_lookahead_distance='-1' max_cost='253'", 21),
     ("max_lookahead_distance='2' stop_at_first_collision='false'", 9)],
)  # fmt: skip
def test_a_path_is_validated_as_far_ahead_as_asked(name: str, ports: str, count: int) -> None:
    path = np.array([[0.5 * k, 0.0, 0.0] for k in range(21)])
    play = Play(f"<{name} path='{{path}}' {ports}/>", path=path)
    play.pose = SE2(2.0, 0.1)
    _, commands = play.tree.tick(TreeState(0.1, play.pose))
    (ask,) = commands
    assert isinstance(ask, Ask)
    assert (ask.kind, len(ask.fields["path"])) == ("IsPathValid", count)


@pytest.mark.parametrize(
    ("port", "valid"),
    [("max_cost='100'", "253 or 254 or 255"), ("layer_name='obstacles'", "valid: none"),
     ("consider_unknown_as_obstacle='true'", "valid: false")],
)  # fmt: skip
def test_what_jazzys_service_cannot_be_asked_is_refused(port: str, valid: str) -> None:
    with pytest.raises(TreeError, match=valid):
        Play(f"<ValidatePath path='{{path}}' {port}/>")


@pytest.mark.parametrize(("port", "enable"), [("", True), ("enable='false'", False)])
def test_the_collision_monitor_is_toggled(port: str, enable: bool) -> None:
    play = Play(f"<ToggleCollisionMonitor {port} service_name='monitor/toggle'/>")
    _, (ask,) = play.tree.tick(TreeState(0.1))
    assert isinstance(ask, Ask)
    assert (ask.kind, ask.server, ask.fields) == ("Toggle", "monitor/toggle", {"enable": enable})
