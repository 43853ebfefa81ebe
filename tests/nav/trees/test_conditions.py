"""Conditions: the values at which they change their answer."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Battery, Topic, TopicKind, TreeState
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
SPIN, WAIT, BACK = "<Spin/>", "<Wait/>", "<BackUp/>"


@pytest.mark.parametrize(
    ("node", "within"),
    [
        ('<GoalReached goal="{goal}"/>', 0.25),
        ('<GoalReached goal="{goal}" goal_reached_tol="1.5"/>', 1.5),
        ('<ArePosesNear ref_pose="{start}" target_pose="{goal}"/>', 0.5),
        ('<ArePosesNear ref_pose="{start}" target_pose="{goal}" tolerance="2"/>', 2.0),
    ],
)
def test_a_pose_is_near_up_to_a_distance(node: str, within: float) -> None:
    start = SE2(3.0, 1.0, 0.5)
    for goal, status in (
        (SE2(3.0 + 0.6 * within, 1.0 - 0.79 * within, 3.0), SUCCESS),
        (SE2(3.0 + 0.62 * within, 1.0 - 0.81 * within, 0.5), FAILURE),
    ):
        play = Play(node, goal=goal, start=start)
        play.pose = start
        assert play.tick() is status


@pytest.mark.parametrize(("given", "unit"), [("", 1.0), ('distance="0.4"', 0.4)])
def test_a_distance_is_measured_from_where_it_began(given: str, unit: float) -> None:
    play = Play(f"<ReactiveFallback><DistanceTraveled {given}/>{WAIT}</ReactiveFallback>")
    statuses = []
    for gone in (5.0, 5.9, 6.1, 7.0, 7.9, 8.1):  # the fourth tick begins again
        play.pose = SE2(0.0, gone * unit)
        statuses.append(play.tick())
    assert statuses == [RUNNING, RUNNING, SUCCESS] * 2


FRAMES = 'global_frame="odom" robot_base_frame="fork"'


def test_a_distance_is_measured_between_the_frames_that_are_named() -> None:
    play = Play(f"<ReactiveFallback><DistanceTraveled {FRAMES}/>{WAIT}</ReactiveFallback>")
    statuses = []
    for gone in (5.0, 5.9, 6.1):
        play.pose = SE2()  # base_footprint in map: it rests
        play.frames = {("odom", "fork"): SE2(gone)}
        statuses.append(play.tick())
    assert statuses == [RUNNING, RUNNING, SUCCESS]


@pytest.mark.parametrize(
    "node",
    [
        f'<GoalReached goal="{{goal}}" {FRAMES}/>',
        f'<IsGoalNearby path="{{path}}" proximity_threshold="0.25" {FRAMES}/>',
    ],
)
def test_the_frame_of_the_robot_that_is_named_reaches_the_goal(node: str) -> None:
    path = np.column_stack((np.linspace(0.0, 3.0, 31), np.zeros((31, 2))))
    for base, fork, status in ((2.0, 3.0, SUCCESS), (3.0, 2.0, FAILURE)):
        play = Play(node, goal=SE2(3.0), path=path)
        play.pose, play.frames = SE2(base), {("", "fork"): SE2(fork)}
        assert play.tick() is status
    play.frames = {}
    assert play.tick() is FAILURE  # where the frame is, is not known


def test_without_a_pose_no_goal_is_reached() -> None:
    for node in ('<GoalReached goal="{goal}"/>', "<InitialPoseReceived/>"):
        tree = Play(node, goal=SE2()).tree
        assert tree.tick(TreeState(0.1))[0] is FAILURE
        assert tree.tick(TreeState(0.2, SE2()))[0] is SUCCESS


@pytest.mark.parametrize("node", ["TimeExpired", "PathExpiringTimer"])
@pytest.mark.parametrize(("given", "ticks"), [("", 10), ('seconds="0.3"', 3)])
def test_time_counts_from_the_first_tick(node: str, given: str, ticks: int) -> None:
    play = Play(f"<ReactiveFallback><{node} {given}/>{WAIT}</ReactiveFallback>")
    play.now = 50.0
    assert [play.tick(dt=0.1001) for _ in range(ticks + 1)] == [RUNNING] * ticks + [SUCCESS]


def test_a_path_that_is_old_counts_once_a_period() -> None:
    play = Play('<Inverter><PathExpiringTimer seconds="0.25"/></Inverter>')
    play.now = 50.0
    old = [i for i in range(10) if play.tick() is FAILURE]
    assert old == [3, 6, 9]


def test_a_new_path_restarts_its_time() -> None:
    play = Play(
        '<ReactiveFallback><PathExpiringTimer seconds="0.25" path="{path}"/><Wait/>'
        "</ReactiveFallback>",
        path=np.zeros((2, 3)),
    )
    play.now = 50.0
    assert [play.tick() for _ in range(3)] == [RUNNING] * 3
    play.tree.blackboard.set("path", np.ones((2, 3)))
    assert [play.tick() for _ in range(4)] == [RUNNING] * 3 + [SUCCESS]


@pytest.mark.parametrize(
    ("node", "mended", "not_mended"),
    [
        ("WouldAControllerRecoveryHelp", (100, 104, 105, 106), (0, 101, 102, 103, 107)),
        ("WouldAPlannerRecoveryHelp", (200, 207, 208, 300, 307, 308), (0, 201, 203, 301)),
        ("WouldASmootherRecoveryHelp", (500, 502, 503, 504), (0, 501, 505)),
        ("WouldARouteRecoveryHelp", (400, 404, 405), (0, 402)),
    ],
)
def test_a_recovery_is_tried_for_what_it_may_mend(
    node: str, mended: tuple[int, ...], not_mended: tuple[int, ...]
) -> None:
    def helps(code: int) -> bool:
        return Play(f'<{node} error_code="{{code}}"/>', code=code).tick() is SUCCESS

    assert [code for code in (*mended, *not_mended) if helps(code)] == list(mended)


def test_error_codes_are_looked_for_among_those_given() -> None:
    node = '<AreErrorCodesPresent error_code="{code}" error_codes_to_check="{look}"/>'
    for look in ("7, 9", "7;9"):
        assert Play(node, code=9, look=look).tick() is SUCCESS
        assert Play(node, code=8, look=look).tick() is FAILURE


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
    play.frames = {("base_link", "map"): SE2()}
    assert play.tick() is FAILURE
    play.frames = {("map", "base_link"): SE2()}
    assert play.tick() is SUCCESS
    play.frames = {}
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


def test_a_topic_is_known_when_the_tree_is_built() -> None:
    with pytest.raises(TreeError, match=r"port 'battery_topic' is {where}; valid: a topic's name"):
        Play('<IsBatteryCharging battery_topic="{where}"/>')
    with pytest.raises(TreeError, match=r"port 'topic_name' is {where}"):
        Play('<PlannerSelector topic_name="{where}" default_planner="A" selected_planner="{p}"/>')


LINE = np.array([[0.5 * k, 0.0, 0.0] for k in range(21)])


@pytest.mark.parametrize(
    ("ports", "x", "status"),
    [("", 8.9, FAILURE), ("", 9.3, SUCCESS), ("proximity_threshold='4'", 6.4, SUCCESS),
     ("max_robot_pose_search_dist='1'", 9.3, FAILURE)],
)  # fmt: skip
def test_a_goal_is_nearby_by_what_is_left_of_the_path(ports: str, x: float, status: Status) -> None:
    play = Play(f"<IsGoalNearby path='{{path}}' {ports}/>")
    assert play.tick() is FAILURE
    play.tree.blackboard.set("path", LINE)
    play.pose = SE2(x, 0.2)
    assert play.tick() is status


def test_a_search_along_the_path_begins_where_it_ended() -> None:
    play = Play("<IsGoalNearby path='{path}' max_robot_pose_search_dist='2'/>", path=LINE)
    statuses = []
    for x in (1.5, 3.0, 4.5, 6.0, 7.5, 9.0, 9.5):
        play.pose = SE2(x)
        statuses.append(play.tick())
    assert statuses == [FAILURE] * 6 + [SUCCESS]


@pytest.mark.parametrize(
    ("ports", "pose", "status"),
    [("", SE2(3.0, 0.4), SUCCESS), ("", SE2(3.0, -0.6), FAILURE),
     ("max_error_right='0.7'", SE2(3.0, -0.6), SUCCESS),
     ("max_error_left='0.3'", SE2(3.0, 0.4), FAILURE),
     ("max_error_heading='-0.5'", SE2(3.0, 0.0, 0.6), FAILURE)],
)  # fmt: skip
def test_a_path_is_tracked_within_bounds(ports: str, pose: SE2, status: Status) -> None:
    bounds = f"<IsWithinPathTrackingBounds {ports}/>"
    play = Play(f"<ReactiveSequence>{bounds}<FollowPath path='{{path}}'/></ReactiveSequence>")
    play.tree.blackboard.set("path", LINE)
    play.pose = pose
    assert play.tick() is RUNNING
    assert play.tick() is (RUNNING if status is SUCCESS else FAILURE)
