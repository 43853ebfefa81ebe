"""Nodes with one child, ticked with made children."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.trees.exchange import Topic, TopicKind, TreeState
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
SKIPPED = Status.SKIPPED
OK, NO = "<AlwaysSuccess/>", "<AlwaysFailure/>"
SPIN, WAIT, BACK = "<Spin/>", "<Wait/>", "<BackUp/>"
PATH = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("xml", "ticks"),
    [
        (f'<Repeat num_cycles="3">{OK}</Repeat>', 2 * [RUNNING, RUNNING, SUCCESS]),
        (
            f'<RetryUntilSuccessful num_attempts="2">{NO}</RetryUntilSuccessful>',
            2 * [RUNNING, FAILURE],
        ),
        (f'<Timeout msec="150">{SPIN}</Timeout>', [RUNNING, RUNNING, FAILURE]),
        (f'<Delay delay_msec="150">{OK}</Delay>', [RUNNING, RUNNING, SUCCESS]),
        (f"<RunOnce>{OK}</RunOnce>", [SUCCESS, SKIPPED]),
        (f'<RunOnce then_skip="false">{OK}</RunOnce>', [SUCCESS, SUCCESS]),
        (f'<DistanceController global_frame="map">{OK}</DistanceController>', [SUCCESS, SUCCESS]),
        (f'<SpeedController goal="{{goal}}">{OK}</SpeedController>', [SUCCESS, SUCCESS]),
        (f"<Sequence><SingleTrigger>{OK}</SingleTrigger></Sequence>", [SUCCESS, SUCCESS]),
        (
            f"<PipelineSequence><SingleTrigger>{OK}</SingleTrigger>{SPIN}</PipelineSequence>",
            [RUNNING, FAILURE, RUNNING],
        ),
        ("<Inverter><GlobalUpdatedGoal/></Inverter>", [FAILURE, SUCCESS]),
        ('<Inverter><PathExpiringTimer seconds="0.15"/></Inverter>', [SUCCESS, SUCCESS, FAILURE]),
        ('<IsPathValid path="{path}"/>', [FAILURE]),
        (f"<GoalUpdatedController>{OK}</GoalUpdatedController>", [SUCCESS, SUCCESS]),
        (
            f'<ReactiveFallback><TimeExpired seconds="0.15"/>{SPIN}</ReactiveFallback>',
            [RUNNING, RUNNING, SUCCESS],
        ),
    ],
)
def test_tick_after_tick(xml: str, ticks: list[Status]) -> None:
    play = Play(xml, goal=SE2())
    assert [play.tick() for _ in ticks] == ticks


def test_goals_pass_a_goal_updater() -> None:
    ports = 'input_goal="{goal}" input_goals="{goals}" output_goals="{out}"'
    play = Play(f"<GoalUpdater {ports}>{OK}</GoalUpdater>", goal=SE2(), goals=(SE2(1.0),))
    assert play.tick() is SUCCESS
    assert play.get("out") == (SE2(1.0),)


def test_a_goal_is_moved() -> None:
    play = Play(
        '<GoalUpdater input_goal="{goal}" output_goal="{moved}"><AlwaysSuccess/></GoalUpdater>',
        goal=SE2(1.0),
    )
    assert play.tree.topics == {Topic(TopicKind.GOAL, "goal_update")}
    play.tick()
    assert play.get("moved") == SE2(1.0)
    play.tree.tick(TreeState(1.0, moved_goal=SE2(2.0)))
    assert play.get("moved") == SE2(2.0)


def test_a_path_that_grows_long_near_the_goal_is_noticed() -> None:
    detour = np.array([[0.0, 0.0, 0.0], [1.0, 4.0, 0.0], [2.0, 0.0, 0.0]])
    play = Play(f'<PathLongerOnApproach path="{{path}}">{WAIT}</PathLongerOnApproach>', path=PATH)
    assert play.tick() is SUCCESS
    play.tree.blackboard.set("path", detour)
    assert play.tick() is RUNNING
    assert play.tick(Wait=True) is SUCCESS
    assert play.tick() is SUCCESS


GIVEN = (
    'SpeedController min_speed="0.2" max_speed="0.6" min_rate="1" max_rate="3"'
    ' filter_duration="0.3"'
)


@pytest.mark.parametrize(
    ("node", "speed", "period", "share"),
    [
        ('RateController hz="2.0"', 0.0, 0.5, 0.01),
        ('RateController hz="0.5"', 0.0, 2.0, 0.01),
        ("SpeedController", 0.0, 10.0, 0.03),
        ("SpeedController", 0.25, 1.0 / 0.55, 0.03),
        ("SpeedController", -0.25, 1.0 / 0.55, 0.03),  # backwards is no slower
        ("SpeedController", 0.5, 1.0, 0.03),
        ("SpeedController", 3.0, 1.0, 0.03),
        (GIVEN, 0.3, 1.0 / 1.5, 0.03),
        (GIVEN, 0.1, 1.0, 0.03),
    ],
)
def test_children_tick_at_a_rate(node: str, speed: float, period: float, share: float) -> None:
    close = f"</{node.split()[0]}>"
    play = Play(f"<PipelineSequence><{node}>{WAIT}{close}<Spin/></PipelineSequence>")
    play.now, play.velocity = 50.0, Velocity(speed)
    play.tick()
    mean = {"R": (), "S": (2.0 / 1.1,)}[node[0]] if node != GIVEN else (0.5,)
    for each in (*mean, period):  # SpeedController's first period is that of the mean rate
        play.tick(Wait=True)
        play.tick(dt=(1.0 - share) * each)
        assert "Wait" not in play.open
        play.tick(dt=2.0 * share * each)
        assert "Wait" in play.open


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
    assert not noticed(3.1, 9.0)  # far from the goal a detour may be right
    assert noticed(3.1, 9.0, given='prox_len="4"')
    assert noticed(2.0, 3.1, given='length_factor="1.5"')
    assert not noticed(2.0, 8.0, end=0.06)  # to another goal
    assert noticed(2.0, 8.0, end=0.04)


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


@pytest.mark.parametrize(
    ("loop", "queue", "values"),
    [
        ("LoopString", "a; b;c", ["a", "b", "c"]),
        ("LoopInt", "1;2", [1, 2]),
        ("LoopDouble", "0.5", [0.5]),
        ("LoopBool", "true;false", [True, False]),
        ("LoopString", "", []),
    ],
)
def test_a_loop_runs_its_child_for_each_value(loop: str, queue: str, values: list[object]) -> None:
    play, seen = Play(f'<{loop} queue="{queue}" value="{{v}}"><Spin/></{loop}>'), []
    while play.tick(**dict.fromkeys(play.open, True)) is RUNNING:
        if play.open:
            seen.append(play.get("v"))
    assert seen == values


def test_a_loop_ends_where_its_child_fails() -> None:
    play = Play('<LoopInt queue="1;2;3" value="{v}"><Spin _failureIf="v == 2"/></LoopInt>')
    play.tick()
    assert play.tick(Spin=True) is RUNNING
    assert play.tick() is FAILURE
    assert play.get("v") == 2


@pytest.mark.parametrize(
    ("xml", "otherwise"),
    [
        ('<SkipUnlessUpdated entry="{a}"><AlwaysSuccess/></SkipUnlessUpdated>', SKIPPED),
        ('<WaitValueUpdated entry="{a}"><AlwaysSuccess/></WaitValueUpdated>', RUNNING),
        ('<WasEntryUpdated entry="a"/>', FAILURE),
    ],
)
def test_an_entry_that_was_written_counts_once(xml: str, otherwise: Status) -> None:
    play = Play(xml)
    assert play.tick() is otherwise
    for _ in range(2):
        play.tree.blackboard.set("a", 1)
        assert [play.tick() for _ in range(3)] == [SUCCESS, otherwise, otherwise]
