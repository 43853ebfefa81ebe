"""What each node of a tree answers: Nav2's and BehaviorTree.CPP's, told by made children."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import Answer, Topic, TopicKind, TreeState
from arjuna_nav.trees.node import Status
from arjuna_nav.trees.ports import entry
from arjuna_nav.trees.xml_file import build_tree
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
PATH = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


OK, NO = "<AlwaysSuccess/>", "<AlwaysFailure/>"
SPIN, WAIT, BACK = "<Spin/>", "<Wait/>", "<BackUp/>"


@pytest.mark.parametrize(
    ("xml", "status"),
    [
        (f"<Sequence>{OK}{OK}</Sequence>", SUCCESS),
        (f"<Sequence>{OK}{NO}{SPIN}</Sequence>", FAILURE),
        (f"<Sequence>{OK}{SPIN}{NO}</Sequence>", RUNNING),
        (f"<Fallback>{NO}{OK}{SPIN}</Fallback>", SUCCESS),
        (f"<Fallback>{NO}{NO}</Fallback>", FAILURE),
        (f"<ReactiveSequence>{OK}{SPIN}</ReactiveSequence>", RUNNING),
        (f"<ReactiveSequence>{NO}{SPIN}</ReactiveSequence>", FAILURE),
        (f"<ReactiveFallback>{NO}{OK}</ReactiveFallback>", SUCCESS),
        (f"<Inverter>{OK}</Inverter>", FAILURE),
        (f"<ForceSuccess>{NO}</ForceSuccess>", SUCCESS),
        (f"<ForceFailure>{OK}</ForceFailure>", FAILURE),
        (f"<KeepRunningUntilFailure>{OK}</KeepRunningUntilFailure>", RUNNING),
        (f"<KeepRunningUntilFailure>{NO}</KeepRunningUntilFailure>", FAILURE),
        (f'<Parallel success_count="1">{SPIN}{OK}</Parallel>', SUCCESS),
        (f'<Parallel success_count="2">{SPIN}{OK}</Parallel>', RUNNING),
        (f'<Parallel failure_count="1">{SPIN}{NO}</Parallel>', FAILURE),
        (f"<IfThenElse>{OK}{OK}{NO}</IfThenElse>", SUCCESS),
        (f"<IfThenElse>{NO}{OK}{NO}</IfThenElse>", FAILURE),
        (f"<IfThenElse>{NO}{OK}</IfThenElse>", FAILURE),
        (f"<WhileDoElse>{NO}{OK}{SPIN}</WhileDoElse>", RUNNING),
        (f"<WhileDoElse>{NO}{OK}</WhileDoElse>", FAILURE),
        (f"<PipelineSequence>{OK}{SPIN}</PipelineSequence>", RUNNING),
        (f"<PipelineSequence>{NO}{SPIN}</PipelineSequence>", FAILURE),
        (f"<RoundRobin>{NO}{NO}</RoundRobin>", FAILURE),
        (f"<RoundRobin>{NO}{OK}</RoundRobin>", SUCCESS),
        (f'<RecoveryNode number_of_retries="3">{NO}{NO}</RecoveryNode>', FAILURE),
        (f'<RecoveryNode number_of_retries="1000000">{NO}{OK}</RecoveryNode>', RUNNING),
        ('<AreErrorCodesPresent error_code="5" error_codes_to_check="3;5"/>', SUCCESS),
        ('<WouldAControllerRecoveryHelp error_code="105"/>', SUCCESS),
        ('<WouldAControllerRecoveryHelp error_code="103"/>', FAILURE),
        ('<WouldAPlannerRecoveryHelp error_code="{none}"/>', FAILURE),
        ('<Condition ID="GoalReached" goal="{goal}"/>', SUCCESS),
    ],
)
def test_the_first_tick(xml: str, status: Status) -> None:
    assert Play(xml, goal=SE2(0.1, 0.1)).tick() is status


def test_a_sequence_goes_on_where_it_was_and_begins_anew_after_its_end() -> None:
    play = Play(f"<Sequence>{SPIN}{WAIT}</Sequence>")
    assert play.tick() is RUNNING
    assert play.tick(Spin=True) is RUNNING
    assert set(play.open) == {"Wait"}
    assert play.tick(Wait=True) is SUCCESS
    play.tick()
    assert set(play.open) == {"Spin"}


def test_a_reactive_node_stops_what_another_takes_the_place_of() -> None:
    play = Play(f"<ReactiveFallback><GoalUpdated/>{SPIN}</ReactiveFallback>", goal=SE2())
    assert play.tick() is RUNNING
    spinning = play.open["Spin"]
    assert play.tick() is RUNNING
    play.tree.blackboard.set("goal", SE2(1.0))
    assert play.tick() is SUCCESS
    assert play.withdrawn == [spinning]
    assert play.tick() is RUNNING  # anew: nothing was updated since


def test_a_pipeline_ticks_the_earlier_ones_again_while_a_later_one_runs() -> None:
    plan = '<ComputePathToPose goal="{goal}" path="{path}"/>'
    play = Play(
        f'<PipelineSequence><RateController hz="1.0">{plan}</RateController>'
        '<FollowPath path="{path}"/></PipelineSequence>',
        goal=SE2(2.0),
    )
    assert play.tick() is RUNNING
    assert set(play.open) == {"ComputePathToPose"}
    play.tick(ComputePathToPose=Answer(True, values={"path": PATH}))
    assert set(play.open) == {"FollowPath"}
    for _ in range(9):
        play.tick()
    assert set(play.open) == {"FollowPath"}
    play.tick()
    assert set(play.open) == {"FollowPath", "ComputePathToPose"}
    before = play.open["FollowPath"]
    play.tick(ComputePathToPose=Answer(True, values={"path": PATH.copy()}))
    assert play.open["FollowPath"] != before  # the new path is followed
    assert not play.withdrawn
    assert play.tick(FollowPath=True) is SUCCESS


def test_recoveries_take_turns_and_are_counted() -> None:
    play = Play(
        f'<RecoveryNode number_of_retries="3">{NO}<RoundRobin>{SPIN}{WAIT}{BACK}</RoundRobin>'
        "</RecoveryNode>"
    )
    for kind in ("Spin", "Wait", "BackUp"):
        assert play.tick(**dict.fromkeys(play.open, True)) is RUNNING
        assert set(play.open) == {kind}
    assert play.tick(BackUp=True) is FAILURE
    assert play.get("number_recoveries") == 3


def test_a_recovery_that_fails_gives_its_turn_to_the_next() -> None:
    play = Play(f"<RoundRobin>{SPIN}{WAIT}</RoundRobin>")
    play.tick()
    assert play.tick(Spin=False) is RUNNING
    assert play.tick(Wait=True) is SUCCESS
    play.tick()
    assert set(play.open) == {"Spin"}


@pytest.mark.parametrize(
    ("xml", "ticks"),
    [
        (f'<Repeat num_cycles="3">{OK}</Repeat>', [RUNNING, RUNNING, SUCCESS]),
        (f'<RetryUntilSuccessful num_attempts="2">{NO}</RetryUntilSuccessful>', [RUNNING, FAILURE]),
        (f'<Timeout msec="150">{SPIN}</Timeout>', [RUNNING, RUNNING, FAILURE]),
        (f'<Delay delay_msec="150">{OK}</Delay>', [RUNNING, RUNNING, SUCCESS]),
        (f"<RunOnce>{OK}</RunOnce>", [SUCCESS, SUCCESS]),
        (f"<Sequence><SingleTrigger>{OK}</SingleTrigger></Sequence>", [SUCCESS, FAILURE]),
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


def test_a_distance_is_measured() -> None:
    play = Play(
        f'<PipelineSequence><DistanceController distance="1.0">{WAIT}</DistanceController>{SPIN}'
        "</PipelineSequence>"
    )
    play.tick()
    play.tick(Wait=True)
    play.pose = SE2(0.9)
    play.tick()
    assert "Wait" not in play.open
    play.pose = SE2(1.1)
    play.tick()
    assert "Wait" in play.open


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


def test_codes_and_messages_are_written() -> None:
    play = Play('<FollowPath path="{path}" error_code_id="{code}" error_msg="{why}"/>', path=PATH)
    play.tick()
    assert play.tick(FollowPath=Answer(False, 105, "stuck")) is FAILURE
    assert (play.get("code"), play.get("why")) == (105, "stuck")
    play.tick()
    assert play.tick(FollowPath=Answer(True, 105, "stuck before")) is SUCCESS
    assert (play.get("code"), play.get("why")) == (0, "")


def test_a_subtree_has_entries_of_its_own() -> None:
    text = (
        '<root BTCPP_format="4" main_tree_to_execute="Main">'
        '<BehaviorTree ID="Main"><Sequence><SubTree ID="Sub" goal="{aim}" speed="0.2"/>'
        '<SubTree ID="Share" _autoremap="true"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="Sub"><Sequence><GoalReached goal="{goal}"/>'
        '<SetBlackboard value="{speed}" output_key="hidden"/>'
        '<SetBlackboard value="{speed}" output_key="@told"/></Sequence></BehaviorTree>'
        '<BehaviorTree ID="Share"><SetBlackboard value="1" output_key="shared"/></BehaviorTree>'
        "</root>"
    )
    tree = build_tree(text, "test.xml")
    tree.blackboard.set("aim", SE2())
    assert tree.tick(TreeState(0.0, SE2()))[0] is SUCCESS
    board = tree.blackboard
    assert [board.get(name) for name in ("hidden", "told", "shared")] == [None, "0.2", "1"]


def test_the_log_says_what_changed() -> None:
    play = Play(f'<Sequence name="all">{OK}{NO}</Sequence>')
    play.tick()
    told = [(c.node, c.uid, c.before, c.after) for c in play.tree.take_changes()]
    assert told[:3] == [
        ("all", 1, "IDLE", "RUNNING"),
        ("AlwaysSuccess", 2, "IDLE", "SUCCESS"),
        ("AlwaysFailure", 3, "IDLE", "FAILURE"),
    ]
    assert ("all", 1, "RUNNING", "FAILURE") in told
    assert play.tree.take_changes() == ()


@pytest.mark.parametrize(
    ("xml", "entries", "says"),
    [
        ('<ComputePathToPose goal="{goal}"/>', {}, "{goal} is not on the blackboard"),
        ('<ComputePathToPose goal="{goal}"/>', {"goal": "there"}, "valid: a pose on"),
        ("<ComputePathToPose/>", {}, "port 'goal': it is not given"),
        ('<Spin spin_dist="{far}"/>', {"far": "much"}, "'much'; valid: a number"),
    ],
)
def test_what_a_node_must_be_given_is_said(xml: str, entries: dict[str, object], says: str) -> None:
    play = Play(xml, **entries)
    with pytest.raises(TreeError, match="port") as error:
        play.tick()
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("text", "name"), [("{goal}", "goal"), (" {a_b} ", "a_b"), ("{goal", None), ("goal}", None)]
)
def test_braces_on_both_sides_name_an_entry(text: str, name: str | None) -> None:
    assert entry(text) == name


@pytest.mark.parametrize(
    ("name", "next_asked"),
    [("Sequence", "Wait"), ("SequenceWithMemory", "Spin"), ("Fallback", "Wait")],
)
def test_what_is_stopped_on_the_way_begins_anew_unless_it_remembers(
    name: str, next_asked: str
) -> None:
    play = Play(f'<Timeout msec="250"><{name}>{WAIT}{SPIN}</{name}></Timeout>')
    play.tick()
    play.tick(Wait=name != "Fallback")
    assert set(play.open) == {"Spin"}
    assert [play.tick() for _ in range(2)][-1] is FAILURE
    assert play.open == {}
    play.tick()
    assert set(play.open) == {next_asked}
