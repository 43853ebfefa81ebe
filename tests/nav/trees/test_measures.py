"""Where nodes of a tree draw their lines: on places, ways, times, speeds and counts."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import TreeState
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
OK, NO, WAIT = "<AlwaysSuccess/>", "<AlwaysFailure/>", "<Wait/>"


@pytest.mark.parametrize(
    ("node", "within"),
    [
        ('<GoalReached goal="{goal}"/>', 0.25),
        ('<GoalReached goal="{goal}" goal_reached_tol="1.5"/>', 1.5),
        ('<ArePosesNear ref_pose="{start}" target_pose="{goal}"/>', 0.5),
        ('<ArePosesNear ref_pose="{start}" target_pose="{goal}" tolerance="2"/>', 2.0),
    ],
)
def test_a_place_is_near_up_to_a_distance(node: str, within: float) -> None:
    start = SE2(3.0, 1.0, 0.5)
    for goal, status in (
        (SE2(3.0 + 0.6 * within, 1.0 - 0.79 * within, 3.0), SUCCESS),
        (SE2(3.0 + 0.62 * within, 1.0 - 0.81 * within, 0.5), FAILURE),
    ):
        play = Play(node, goal=goal, start=start)
        play.pose = start
        assert play.tick() is status


@pytest.mark.parametrize(("given", "way"), [("", 1.0), ('distance="0.4"', 0.4)])
def test_the_way_gone_is_measured_from_where_it_began(given: str, way: float) -> None:
    play = Play(f"<ReactiveFallback><DistanceTraveled {given}/>{WAIT}</ReactiveFallback>")
    told = []
    for gone in (5.0, 5.9, 6.1, 7.0, 7.9, 8.1):  # the fourth tick begins anew
        play.pose = SE2(0.0, gone * way)
        told.append(play.tick())
    assert told == [RUNNING, RUNNING, SUCCESS] * 2


def test_without_a_pose_no_place_is_reached_and_no_way_gone() -> None:
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


def test_a_path_that_is_old_is_told_once_a_period() -> None:
    play = Play('<Inverter><PathExpiringTimer seconds="0.25"/></Inverter>')
    play.now = 50.0
    old = [i for i in range(10) if play.tick() is FAILURE]
    assert old == [3, 6, 9]


def test_a_new_path_begins_its_time_anew() -> None:
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
    ("speed", "given", "period"),
    [
        (0.0, "", 10.0),
        (0.25, "", 1.0 / 0.55),
        (-0.25, "", 1.0 / 0.55),  # backwards is no slower
        (0.5, "", 1.0),
        (3.0, "", 1.0),
        (0.3, 'min_speed="0.2" max_speed="0.6" min_rate="1" max_rate="3"', 1.0 / 1.5),
        (0.1, 'min_speed="0.2" max_speed="0.6" min_rate="1" max_rate="3"', 1.0),
    ],
)
def test_the_faster_the_robot_the_more_often(speed: float, given: str, period: float) -> None:
    play = Play(
        f"<PipelineSequence><SpeedController {given}>{WAIT}</SpeedController><Spin/>"
        "</PipelineSequence>"
    )
    play.now, play.velocity = 50.0, Velocity(speed)
    play.tick()
    play.tick(Wait=True)
    play.tick(dt=0.97 * period)
    assert "Wait" not in play.open
    play.tick(dt=0.06 * period)
    assert "Wait" in play.open


@pytest.mark.parametrize(
    ("place", "radius", "left"),
    [
        (SE2(0.0, 0.3), "", 2),
        (SE2(0.0, 0.6), "", 3),
        (SE2(0.0, 0.6), 'radius="0.7"', 2),
        (SE2(0.5, 0.0), 'radius="0.6"', 1),
        (SE2(2.0, 0.0), 'radius="5"', 1),
    ],
)
def test_goals_that_were_passed_go_but_for_the_last(place: SE2, radius: str, left: int) -> None:
    goals = (SE2(), SE2(1.0), SE2(2.0))
    node = f'<RemovePassedGoals input_goals="{{goals}}" output_goals="{{goals}}" {radius}/>'
    play = Play(node, goals=goals)
    play.pose = place
    assert play.tick() is SUCCESS
    assert play.get("goals") == goals[3 - left :]


@pytest.mark.parametrize(
    ("given", "last"),
    [("", 1.5), ('distance="0.9"', 1.5), ('distance="0.1"', 2.0), ('distance="7"', 0.0)],
)
def test_the_end_of_a_path_is_left_out(given: str, last: float) -> None:
    path = np.array([[0.5 * i, 0.0, 0.0] for i in range(6)])
    play = Play(f'<TruncatePath input_path="{{path}}" output_path="{{short}}" {given}/>', path=path)
    assert play.tick() is SUCCESS
    short = play.get("short")
    assert isinstance(short, np.ndarray)
    assert short[-1, 0] == last
    np.testing.assert_array_equal(short, path[: len(short)])


@pytest.mark.parametrize(
    ("node", "mended", "not_mended"),
    [
        ("WouldAControllerRecoveryHelp", (100, 104, 105, 106), (0, 101, 102, 103, 107)),
        ("WouldAPlannerRecoveryHelp", (200, 207, 208, 300, 307, 308), (0, 201, 203, 301)),
        ("WouldASmootherRecoveryHelp", (500, 502, 503, 504), (0, 501, 505)),
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


def test_a_path_is_a_detour_from_twice_the_length_and_near_the_goal_only() -> None:
    def noticed(old: float, new: float, end: float = 0.0, given: str = "") -> bool:
        before = np.array([[-old, 0.0, 0.0], [0.0, 0.0, 0.0]])
        after = np.array(
            [[-old, 0.0, 0.0], [-old + (new - old) / 2 + old, 0.0, 0.0], [end, 0.0, 0.0]]
        )
        node = f'<PathLongerOnApproach path="{{path}}" {given}>{WAIT}</PathLongerOnApproach>'
        play = Play(node, path=before)
        assert play.tick() is SUCCESS
        play.tree.blackboard.set("path", after)
        return play.tick() is RUNNING

    assert noticed(2.9, 5.9)
    assert not noticed(2.9, 5.7)
    assert not noticed(3.1, 9.0)  # far from the goal a way round may be right
    assert noticed(3.1, 9.0, given='prox_len="4"')
    assert noticed(2.0, 3.1, given='length_factor="1.5"')
    assert not noticed(2.0, 8.0, end=0.06)  # to another goal
    assert noticed(2.0, 8.0, end=0.04)


@pytest.mark.parametrize(
    ("node", "entries", "says"),
    [
        ('<TruncatePath input_path="{path}" output_path="{o}"/>', {"path": "text"}, "a path"),
        ('<GoalReached goal="{goal}"/>', {"goal": (1, 2)}, "a pose"),
        ('<GoalReached goal="{g}" goal_reached_tol="{t}"/>', {"g": SE2(), "t": "nan"}, "a number"),
        ('<Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>', {"n": 1.5}, "a whole number"),
    ],
)
def test_an_entry_of_another_kind_is_refused(
    node: str, entries: dict[str, object], says: str
) -> None:
    play = Play(node, **entries)
    with pytest.raises(TreeError, match=says):
        play.tick()


def test_a_goal_that_changes_has_the_child_ticked_again() -> None:
    play = Play(f"<GoalUpdatedController>{WAIT}</GoalUpdatedController>", goal=SE2(1.0))
    play.tick()
    assert play.tick(Wait=True) is SUCCESS
    play = Play(
        f"<PipelineSequence><GoalUpdatedController>{WAIT}</GoalUpdatedController><Spin/>"
        "</PipelineSequence>",
        goal=SE2(1.0),
    )
    play.tick()
    play.tick(Wait=True)
    for _ in range(3):
        assert play.tick() is RUNNING
        assert set(play.open) == {"Spin"}
    for name, value in (("goal", SE2(2.0)), ("goals", (SE2(2.0),))):
        play.tree.blackboard.set(name, value)
        play.tick()
        assert "Wait" in play.open
        play.tick(Wait=True)


@pytest.mark.parametrize(("gone", "again"), [(0.99, False), (1.0, True)])
def test_a_distance_is_gone_once_it_is_reached(gone: float, again: bool) -> None:
    play = Play(
        f"<PipelineSequence><DistanceController>{WAIT}</DistanceController><Spin/>"
        "</PipelineSequence>"
    )
    play.tick()
    play.tick(Wait=True)
    play.pose = SE2(gone)
    play.tick()
    assert ("Wait" in play.open) is again


@pytest.mark.parametrize(("hz", "period"), [("2.0", 0.5), ("0.5", 2.0)])
def test_a_rate_is_so_often_a_second(hz: str, period: float) -> None:
    play = Play(
        f'<PipelineSequence><RateController hz="{hz}">{WAIT}</RateController><Spin/>'
        "</PipelineSequence>"
    )
    play.now = 50.0
    play.tick()
    play.tick(Wait=True)
    play.tick(dt=0.99 * period)
    assert "Wait" not in play.open
    play.tick(dt=0.02 * period)
    assert "Wait" in play.open
