"""Actions on the blackboard, goals, paths and choices of plug-ins."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.exchange import Topic, TopicKind
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
PATH = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
STRAIGHT = np.column_stack((np.arange(11.0), np.zeros(11), np.zeros(11)))
EMPTY = np.empty((0, 3))
HAIRPIN = np.concatenate((STRAIGHT, STRAIGHT[::-1] + np.array([0.0, 1.0, math.pi])))


def test_goals_paths_and_choices_on_the_blackboard() -> None:
    goals = (SE2(0.3), SE2(1.0), SE2(3.0))
    play = Play(
        '<Sequence><RemovePassedGoals input_goals="{goals}" output_goals="{left}" radius="0.5"/>'
        '<TruncatePath distance="0.5" input_path="{path}" output_path="{short}"/>'
        '<SetBlackboard value="42" output_key="answer"/>'
        '<PlannerSelector selected_planner="{planner}" default_planner="GridBased"/>'
        '<UnsetBlackboard key="path"/></Sequence>',
        goals=goals,
        path=PATH,
    )
    assert play.tick() is SUCCESS
    assert play.get("left") == goals[1:]
    assert play.get("short") == pytest.approx(PATH[:2])
    assert (play.get("answer"), play.get("planner"), play.get("path")) == ("42", "GridBased", None)
    assert play.tree.topics == {Topic(TopicKind.CHOICE, "planner_selector")}


@pytest.mark.parametrize(
    ("pose", "radius", "left"),
    [
        (SE2(0.0, 0.3), "", 2),
        (SE2(0.0, 0.6), "", 3),
        (SE2(0.0, 0.6), 'radius="0.7"', 2),
        (SE2(0.5, 0.0), 'radius="0.6"', 1),
        (SE2(2.0, 0.0), 'radius="5"', 1),
    ],
)
def test_goals_that_were_passed_go_but_for_the_last(pose: SE2, radius: str, left: int) -> None:
    goals = (SE2(), SE2(1.0), SE2(2.0))
    node = f'<RemovePassedGoals input_goals="{{goals}}" output_goals="{{goals}}" {radius}/>'
    play = Play(node, goals=goals)
    play.pose = pose
    assert play.tick() is SUCCESS
    assert play.get("goals") == goals[3 - left :]


GOALS = (SE2(0.0, 1.0, 0.5), SE2(1.0), SE2(2.0))


@pytest.mark.parametrize(
    ("node", "made"),
    [
        ('<GetNextFewGoals input_goals="{goals}" output_goals="{out}" num_goals="2"/>', GOALS[:2]),
        ('<GetNextFewGoals input_goals="{goals}" output_goals="{out}" num_goals="9"/>', GOALS),
        ('<GetNextFewGoals input_goals="{no}" output_goals="{out}" num_goals="9"/>', None),
        (
            '<AppendGoalPoseToGoals input_goals="{goals}" goal_pose="{end}" output_goals="{out}"/>',
            (*GOALS, SE2(7.0)),
        ),
        ('<AppendGoalPoseToGoals goal_pose="{end}" output_goals="{out}"/>', (SE2(7.0),)),
        ('<ExtractRouteNodesAsGoals route="{goals}" goals="{out}"/>', (SE2(0.0, 1.0), *GOALS[1:])),
        ('<ExtractRouteNodesAsGoals route="{no}" goals="{out}"/>', None),
    ],
)
def test_goals_are_made_of_others(node: str, made: tuple[SE2, ...] | None) -> None:
    play = Play(node, goals=GOALS, no=(), end=SE2(7.0))
    assert play.tick() is (FAILURE if made is None else SUCCESS)
    assert play.get("out") == made


@pytest.mark.parametrize(
    ("given", "last"),
    [("", 1.5), ('distance="0.9"', 1.5), ('distance="0.1"', 2.0)],
)
def test_the_end_of_a_path_is_left_out(given: str, last: float) -> None:
    path = np.array([[0.5 * i, 0.0, 0.0] for i in range(6)])
    play = Play(f'<TruncatePath input_path="{{path}}" output_path="{{short}}" {given}/>', path=path)
    assert play.tick() is SUCCESS
    short = play.get("short")
    assert isinstance(short, np.ndarray)
    assert short[-1, 0] == last
    np.testing.assert_array_equal(short, path[: len(short)])


def test_who_is_near_enough_to_the_end_stands_and_faces_it() -> None:
    path = np.array([[1.0, 0.0, 0.1], [1.0, 0.5, 0.2], [0.0, 0.5, 0.3]])
    play = Play('<TruncatePath input_path="{path}" output_path="{out}" distance="7"/>', path=path)
    assert play.tick() is SUCCESS
    there = [1.0, 0.0, math.atan2(0.5, -1.0)]
    assert play.get("out") == pytest.approx(np.array([path[0], there]))


def test_the_last_pose_of_a_cut_path_faces_the_end_as_the_crow_flies() -> None:
    path = np.array([[0.0, 0.0, 0.1], [0.0, 2.0, 0.2], [0.0, 3.0, 0.3], [0.5, 2.0, 0.4]])
    play = Play('<TruncatePath input_path="{path}" output_path="{out}" distance="1.1"/>', path=path)
    assert play.tick() is SUCCESS
    assert play.get("out") == pytest.approx(
        np.array([*path[:2], [0.0, 3.0, math.atan2(-1.0, 0.5)]])
    )
    play.tree.blackboard.set("path", path[-1:])
    assert play.tick() is SUCCESS
    assert play.get("out") == pytest.approx(np.array([[0.5, 2.0, 0.0]]))


def cut(ports: str, path: object = STRAIGHT, **entries: object) -> Play:
    xml = f'<TruncatePathLocal input_path="{{path}}" output_path="{{out}}" {ports}/>'
    return Play(xml, path=path, **entries)


@pytest.mark.parametrize(
    ("ports", "x", "kept"),
    [
        ("", 0.0, range(9)),  # 8 m ahead
        ("", 10.0, range(6, 11)),  # 4 m behind
        ('distance_forward="2" distance_backward="1"', 5.2, range(4, 8)),
        ('distance_forward="0" distance_backward="0"', 4.6, range(5, 6)),
        ('distance_forward="1.5" distance_backward="0.5"', 3.0, range(3, 5)),
    ],
)
def test_a_path_is_cut_about_the_robot(ports: str, x: float, kept: range) -> None:
    play = cut(ports)
    play.pose = SE2(x, 0.3)
    assert play.tick() is SUCCESS
    np.testing.assert_array_equal(play.get("out"), STRAIGHT[kept.start : kept.stop])


def test_a_pose_given_replaces_the_robots() -> None:
    play = cut('pose="{there}" distance_forward="1" distance_backward="1"', there=SE2(7.0))
    assert play.tick() is SUCCESS
    np.testing.assert_array_equal(play.get("out"), STRAIGHT[6:9])


def test_the_heading_distinguishes_the_path_there_from_the_path_back() -> None:
    near = 'distance_forward="0" distance_backward="0" angular_distance_weight='
    for weight, y in (("0", 0.0), ("1", 1.0)):
        play = cut(f'{near}"{weight}"', HAIRPIN)
        play.pose = SE2(3.0, 0.4, math.pi)
        play.tick()
        out = play.get("out")
        assert isinstance(out, np.ndarray)
        assert out[0, :2] == pytest.approx((3.0, y))


def test_the_robot_is_looked_for_on_from_where_it_was_and_not_too_far_ahead() -> None:
    play = cut('distance_forward="0" distance_backward="0" max_robot_pose_search_dist="3"', HAIRPIN)
    starts = []
    for x, y in ((0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (9.0, 0.0), (1.0, 0.0)):
        play.pose = SE2(x, y)
        play.tick()
        out = play.get("out")
        assert isinstance(out, np.ndarray)
        starts.append(float(out[0, 0]))
    assert starts == [0.0, 2.0, 4.0, 7.0, 7.0], "no farther than 3 m, and never back"
    play.tree.blackboard.set("path", HAIRPIN.copy())
    play.tick()
    out = play.get("out")
    assert isinstance(out, np.ndarray)
    assert out[0, 0] == 1.0, "a new path is looked at from its start"


def test_nothing_is_cut_of_no_path_or_by_a_robot_that_is_nowhere() -> None:
    play = cut("", EMPTY)
    assert play.tick() is SUCCESS
    assert play.get("out") is EMPTY
    play = cut('max_robot_pose_search_dist="-1"')
    assert play.tick() is SUCCESS
    play = cut("")
    play.pose = None
    assert play.tick() is FAILURE


@pytest.mark.parametrize(
    "node",
    [
        '<TruncatePathLocal input_path="{path}"',
        '<TruncatePath input_path="{path}"',
        '<ConcatenatePaths input_path1="{path}" input_path2="{path}"',
    ],
)
def test_a_path_that_stays_the_same_is_not_followed_again(node: str) -> None:
    follow = '<FollowPath path="{out}"/>'
    play = Play(f'<ReactiveSequence>{node} output_path="{{out}}"/>{follow}</ReactiveSequence>')
    play.tree.blackboard.set("path", STRAIGHT)
    play.tick()
    following = play.open["FollowPath"]
    play.tick()
    assert play.open["FollowPath"] == following
    play.tree.blackboard.set("path", STRAIGHT.copy())
    play.tick()
    assert play.open["FollowPath"] != following, "another plan, if an equal one"


def test_a_path_that_is_cut_elsewhere_is_followed_again() -> None:
    play = Play(
        '<ReactiveSequence><TruncatePathLocal input_path="{path}" output_path="{near}"/>'
        '<FollowPath path="{near}"/></ReactiveSequence>',
        path=STRAIGHT,
    )
    play.tick()
    following = play.open["FollowPath"]
    play.pose = SE2(2.0)
    play.tick()
    assert play.open["FollowPath"] != following


@pytest.mark.parametrize(
    ("first", "second", "length"),
    [(STRAIGHT, HAIRPIN, 33), (STRAIGHT, None, 11), (None, HAIRPIN, 22), (EMPTY, STRAIGHT, 11)],
)
def test_paths_are_joined(first: object, second: object, length: int) -> None:
    xml = '<ConcatenatePaths input_path1="{a}" input_path2="{b}" output_path="{out}"/>'
    play = Play(xml, a=first, b=second)
    assert play.tick() is SUCCESS
    out = play.get("out")
    assert isinstance(out, np.ndarray)
    assert len(out) == length
    assert Play(xml, a=EMPTY).tick() is FAILURE


@pytest.mark.parametrize(
    ("index", "x"), [("0", 0.0), ("3", 3.0), ("-1", 10.0), ("10", 10.0), ("-11", 0.0)]
)
def test_a_pose_of_a_path(index: str, x: float) -> None:
    play = Play(f'<GetPoseFromPath path="{{path}}" index="{index}" pose="{{p}}"/>', path=STRAIGHT)
    assert play.tick() is SUCCESS
    assert play.get("p") == SE2(x)


@pytest.mark.parametrize("index", ["11", "-12"])
def test_a_pose_that_a_path_has_not(index: str) -> None:
    play = Play(f'<GetPoseFromPath path="{{path}}" index="{index}" pose="{{p}}"/>', path=STRAIGHT)
    assert play.tick() is FAILURE


def test_where_the_robot_is() -> None:
    play = Play('<GetCurrentPose current_pose="{here}"/>')
    play.pose = SE2(1.0, 2.0, 0.5)
    assert play.tick() is SUCCESS
    assert play.get("here") == play.pose
    play.pose = None
    assert play.tick() is FAILURE


def test_the_frame_of_the_robot_that_is_named_counts() -> None:
    play = Play(
        '<Sequence><GetCurrentPose robot_base_frame="fork" current_pose="{here}"/>'
        '<RemovePassedGoals robot_base_frame="fork" input_goals="{goals}" output_goals="{goals}"/>'
        '<TruncatePathLocal robot_frame="fork" input_path="{path}" output_path="{near}"'
        ' distance_forward="0.5" distance_backward="0.0"/></Sequence>',
        path=STRAIGHT,
        goals=(SE2(1.0), SE2(2.0)),
    )
    play.frames = {("", "fork"): SE2(1.0)}
    assert play.tick() is SUCCESS
    near = play.get("near")
    assert isinstance(near, np.ndarray)
    assert (play.get("here"), play.get("goals"), near[0, 0]) == (SE2(1.0), (SE2(2.0),), 1.0)


def test_a_script_changes_entries() -> None:
    play = Play('<Script code="b := a * 2; a += 1"/>', a=1)
    assert play.tick() is SUCCESS
    assert (play.get("a"), play.get("b")) == (2, 2)


def test_sleep_lasts() -> None:
    play = Play('<Sleep msec="150"/>')
    assert [play.tick() for _ in range(6)] == [RUNNING, RUNNING, SUCCESS] * 2
