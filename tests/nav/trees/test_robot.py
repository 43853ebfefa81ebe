"""Claims: tree nodes judge motion, battery and frames, and ask for routes, as Nav2's do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Answer, Ask, Battery, Topic, TopicKind, TreeState
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE


def speeds(xml: str, *velocities: Velocity, dt: float = 0.1) -> list[Status]:
    play, answers = Play(xml), []
    for velocity in velocities:
        play.velocity = velocity
        answers.append(play.tick(dt))
    return answers


@pytest.mark.parametrize(
    ("after", "stuck"), [(0.0, True), (0.05, False), (-0.05, False), (0.9, False)]
)
def test_a_robot_that_stops_harder_than_it_brakes_is_stuck(after: float, stuck: bool) -> None:
    # 0.52 m/s in 50 ms are 10.4 m/s^2, 0.47 m/s are 9.4
    for sign in (1.0, -1.0):
        play, said = Play("<IsStuck/>"), []
        for k, speed in enumerate((0.52, 0.52, 0.52, after, after)):
            play.velocity, play.measured_at = Velocity(speed * sign), 0.05 * (k // 3)
            said.append(play.tick(0.01))  # it is ticked more often than odometry comes
        assert said == [FAILURE] * 3 + [SUCCESS if stuck else FAILURE] * 2
        play.measured_at += 0.05
        assert play.tick() is FAILURE


def test_a_robot_has_stopped_once_it_stood_long_enough() -> None:
    xml = '<IsStopped duration_stopped="250" velocity_threshold="0.1"/>'
    slow, turning = Velocity(0.09, yaw_rate=-0.09), Velocity(yaw_rate=0.1)
    said = speeds(xml, Velocity(0.1), slow, slow, slow, slow, slow, turning, STILL)
    assert said == [FAILURE, RUNNING, RUNNING, RUNNING, SUCCESS, RUNNING, FAILURE, RUNNING]
    assert speeds("<IsStopped/>", STILL, STILL, STILL, dt=0.55) == [RUNNING, RUNNING, SUCCESS]


def test_a_transform_that_was_known_once_is_known() -> None:
    play = Play('<TransformAvailable parent="map" child="base_link"/>')
    play.frames = {("base_link", "map")}
    assert play.tick() is FAILURE
    play.frames = {("map", "base_link")}
    assert play.tick() is SUCCESS
    play.frames = set()
    assert play.tick() is SUCCESS


@pytest.mark.parametrize(
    ("ports", "battery", "low"),
    [
        ('min_battery="0.2"', Battery(0.2, 24.0, False), True),
        ('min_battery="0.2"', Battery(0.21, 0.1, False), False),
        ('min_battery="22" is_voltage="true"', Battery(0.9, 21.9, False), True),
        ('min_battery="22" is_voltage="true"', Battery(0.1, 22.1, False), False),
    ],
)
def test_a_battery_is_low(ports: str, battery: Battery, low: bool) -> None:
    play = Play(f'<IsBatteryLow battery_topic="/bat" {ports}/>')
    assert play.tree.topics == {Topic(TopicKind.BATTERY, "/bat")}
    assert play.tick() is FAILURE, "nothing is known of it"
    play.batteries = {"/bat": battery, "/other": Battery(0.0, 0.0, True)}
    assert play.tick() is (SUCCESS if low else FAILURE)


def test_a_battery_is_being_charged() -> None:
    play = Play("<IsBatteryCharging/>")
    assert play.tick() is FAILURE
    for charges in (True, False):
        play.batteries = {"/battery_status": Battery(0.5, 12.0, charges)}
        assert play.tick() is (SUCCESS if charges else FAILURE)


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
        told = {"last_node_id": last, "next_node_id": last + 1, "current_edge_id": 9}
        play.feedback = {"ComputeAndTrackRoute": {**told, "path": path, "rerouted": new}}
        assert play.tick() is RUNNING
        assert [play.get(name) for name in ("last", "next", "edge", "new")] == [
            *(last, last + 1, 9),
            new,
        ]
        assert play.get("p") is path
    play.tree.blackboard.set("p", first)
    assert play.tick() is RUNNING
    assert play.get("p") is first, "what was told once is not written again"
    done = Answer(True, values={"execution_duration": 3.5})
    assert play.tick(ComputeAndTrackRoute=done) is SUCCESS
    assert play.get("took") == 3.5


@pytest.mark.parametrize("node", ["ComputeRoute", "ComputeAndTrackRoute"])
def test_a_goal_that_changes_is_asked_for_anew(node: str) -> None:
    play = Play(f'<{node} goal="{{goal}}" use_poses="true" route="{{r}}"/>', goal=SE2(1.0))
    play.tick()
    first = play.open[node]
    assert play.tick() is RUNNING
    assert play.open[node] == first
    play.tree.blackboard.set("goal", SE2(2.0))
    play.tick()
    assert play.open[node] != first
    assert play.tick(**{node: True}) is SUCCESS


def test_a_topic_is_known_when_the_tree_is_built() -> None:
    with pytest.raises(TreeError, match=r"port 'battery_topic' is {where}; valid: a topic's name"):
        Play('<IsBatteryCharging battery_topic="{where}"/>')
    with pytest.raises(TreeError, match=r"port 'topic_name' is {where}"):
        Play('<PlannerSelector topic_name="{where}" default_planner="A" selected_planner="{p}"/>')


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


@pytest.mark.parametrize(
    ("code", "helps"), [(400, True), (404, True), (405, True), (402, False), (0, False)]
)
def test_which_failures_of_routes_may_be_mended(code: int, helps: bool) -> None:
    play = Play(f'<WouldARouteRecoveryHelp error_code="{code}"/>')
    assert play.tick() is (SUCCESS if helps else FAILURE)
