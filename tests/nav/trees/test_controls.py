"""Nodes with several children, ticked with made children."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
SKIPPED = Status.SKIPPED
OK, NO = "<AlwaysSuccess/>", "<AlwaysFailure/>"
SPIN, WAIT, BACK = "<Spin/>", "<Wait/>", "<BackUp/>"
PATH = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
SKIP = '<AlwaysFailure _skipIf="true"/>'


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
        (f'<Parallel success_threshold="1">{SPIN}{OK}</Parallel>', SUCCESS),
        (f'<Parallel failure_threshold="2">{SPIN}{NO}</Parallel>', FAILURE),
        (f'<Parallel success_count="1" failure_threshold="2">{SPIN}{NO}</Parallel>', RUNNING),
        (f'<RetryUntilSuccesful num_attempts="1">{NO}</RetryUntilSuccesful>', FAILURE),
        (f"<IfThenElse>{OK}{OK}{NO}</IfThenElse>", SUCCESS),
        (f"<IfThenElse>{NO}{OK}{NO}</IfThenElse>", FAILURE),
        (f"<IfThenElse>{NO}{OK}</IfThenElse>", FAILURE),
        (f"<WhileDoElse>{NO}{OK}{SPIN}</WhileDoElse>", RUNNING),
        (f"<WhileDoElse>{NO}{OK}</WhileDoElse>", FAILURE),
        (f"<PipelineSequence>{OK}{SPIN}</PipelineSequence>", RUNNING),
        (f"<PipelineSequence>{NO}{SPIN}</PipelineSequence>", FAILURE),
        (f"<NonblockingSequence>{OK}{SKIP}{OK}</NonblockingSequence>", SUCCESS),
        (f"<NonblockingSequence>{SPIN}{NO}</NonblockingSequence>", FAILURE),
        (f"<PersistentSequence>{OK}{SKIP}</PersistentSequence>", SUCCESS),
        (f"<PersistentSequence>{OK}{NO}{SPIN}</PersistentSequence>", FAILURE),
        (f"<RoundRobin>{NO}{NO}</RoundRobin>", FAILURE),
        (f"<RoundRobin>{NO}{OK}</RoundRobin>", SUCCESS),
        (f'<RecoveryNode number_of_retries="3">{NO}{NO}</RecoveryNode>', FAILURE),
        (f'<RecoveryNode number_of_retries="1000000">{NO}{OK}</RecoveryNode>', RUNNING),
        ('<AreErrorCodesPresent error_code="5" error_codes_to_check="3;5"/>', SUCCESS),
        ('<WouldAControllerRecoveryHelp error_code="105"/>', SUCCESS),
        ('<WouldAControllerRecoveryHelp error_code="103"/>', FAILURE),
        ('<WouldAPlannerRecoveryHelp error_code="{none}"/>', FAILURE),
        ('<Condition ID="GoalReached" goal="{goal}"/>', SUCCESS),
        (f"<Sequence>{SKIP}{OK}</Sequence>", SUCCESS),
        (f"<Sequence>{SKIP}{SKIP}</Sequence>", SKIPPED),
        (f"<Fallback>{SKIP}{NO}</Fallback>", FAILURE),
        (f"<Fallback>{SKIP}{SKIP}</Fallback>", SKIPPED),
        (f"<ReactiveSequence>{SKIP}{OK}</ReactiveSequence>", SUCCESS),
        (f"<ReactiveFallback>{SKIP}{SKIP}</ReactiveFallback>", SKIPPED),
        (f"<Parallel>{SKIP}{OK}</Parallel>", SUCCESS),
        (f"<Parallel>{SKIP}{SKIP}</Parallel>", SKIPPED),
        (f"<RoundRobin>{SKIP}{SKIP}</RoundRobin>", SKIPPED),
        (f"<RoundRobin>{SKIP}{NO}</RoundRobin>", FAILURE),
        (f"<ParallelAll>{SKIP}{OK}</ParallelAll>", SUCCESS),
        (f'<ParallelAll max_failures="2">{NO}{OK}</ParallelAll>', SUCCESS),
        (f'<ParallelAll max_failures="1">{NO}{OK}</ParallelAll>', FAILURE),
        (f'<ParallelAll max_failures="-1">{NO}{OK}</ParallelAll>', SUCCESS),
        (f'<ParallelAll max_failures="-1">{NO}{NO}</ParallelAll>', FAILURE),
        (f"<ParallelAll>{NO}{SPIN}</ParallelAll>", RUNNING),
        (f"<Inverter>{SKIP}</Inverter>", SKIPPED),
        (f"<ForceSuccess>{SKIP}</ForceSuccess>", SKIPPED),
        (f"<IfThenElse>{SKIP}{OK}{NO}</IfThenElse>", FAILURE),
        ('<ScriptCondition code="a == 1"/>', SUCCESS),
        ('<ScriptCondition code="a == 2"/>', FAILURE),
        (f'<Precondition if="a == 1">{OK}</Precondition>', SUCCESS),
        (f'<Precondition if="a == 2">{OK}</Precondition>', FAILURE),
        (f'<Precondition if="a == 2" else="SKIPPED">{OK}</Precondition>', SKIPPED),
    ],
)
def test_the_first_tick(xml: str, status: Status) -> None:
    assert Play(xml, goal=SE2(0.1, 0.1), a=1).tick() is status


def test_a_sequence_resumes_where_it_was_and_begins_again_after_its_end() -> None:
    play = Play(f"<Sequence>{SPIN}{WAIT}</Sequence>")
    assert play.tick() is RUNNING
    assert play.tick(Spin=True) is RUNNING
    assert set(play.open) == {"Wait"}
    assert play.tick(Wait=True) is SUCCESS
    play.tick()
    assert set(play.open) == {"Spin"}


def test_a_reactive_node_stops_the_child_that_another_replaces() -> None:
    play = Play(f"<ReactiveFallback><GoalUpdated/>{SPIN}</ReactiveFallback>", goal=SE2())
    assert play.tick() is RUNNING
    spinning = play.open["Spin"]
    assert play.tick() is RUNNING
    play.tree.blackboard.set("goal", SE2(1.0))
    assert play.tick() is SUCCESS
    assert play.withdrawn == [spinning]
    assert play.tick() is RUNNING  # again: nothing was updated since


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
    ("name", "next_asked"),
    [("Sequence", "Wait"), ("SequenceWithMemory", "Spin"), ("Fallback", "Wait")],
)
def test_a_stopped_control_restarts_unless_it_remembers(name: str, next_asked: str) -> None:
    play = Play(f'<Timeout msec="250"><{name}>{WAIT}{SPIN}</{name}></Timeout>')
    play.tick()
    play.tick(Wait=name != "Fallback")
    assert set(play.open) == {"Spin"}
    assert [play.tick() for _ in range(2)][-1] is FAILURE
    assert play.open == {}
    play.tick()
    assert set(play.open) == {next_asked}


def test_a_parallel_node_that_has_enough_asks_no_other() -> None:
    for first, status in ((OK, SUCCESS), (NO, FAILURE)):
        play = Play(f'<Parallel success_count="1" failure_count="1">{first}{SPIN}</Parallel>')
        assert (play.tick(), play.open, play.withdrawn) == (status, {}, [])


@pytest.mark.parametrize(
    ("variable", "asked"), [("go", "Spin"), ("1", "Wait"), (1.0, "Wait"), ("x", "BackUp")]
)
def test_a_switch_runs_the_case_of_its_variable(variable: object, asked: str) -> None:
    play = Play(
        '<Switch2 variable="{v}" case_1="go" case_2="1"><Spin/><Wait/><BackUp/></Switch2>',
        v=variable,
    )
    assert play.tick() is RUNNING
    assert set(play.open) == {asked}
    assert play.tick(**{asked: True}) is SUCCESS


def test_a_switch_leaves_a_case_that_is_no_longer_its_variables() -> None:
    play = Play('<Switch2 variable="{v}" case_1="a" case_2="b"><Spin/><Wait/><BackUp/></Switch2>')
    for value, asked in (("a", "Spin"), ("b", "Wait"), (None, "BackUp")):
        play.tree.blackboard.set("v", value)
        assert play.tick() is RUNNING
        assert set(play.open) == {asked}


def test_a_sequence_that_blocks_nobody_runs_all_and_those_that_ended_again() -> None:
    play = Play(f"<NonblockingSequence>{SPIN}{WAIT}</NonblockingSequence>")
    assert play.tick() is RUNNING
    assert set(play.open) == {"Spin", "Wait"}
    assert play.tick(Spin=Answer(True)) is RUNNING
    play.tick()
    assert set(play.open) == {"Spin", "Wait"}
    assert play.tick(Spin=Answer(True), Wait=Answer(True)) is SUCCESS


def test_a_persistent_sequence_goes_on_where_it_was_halted() -> None:
    sequence = f"<PersistentSequence current_child_idx='{{at}}'>{SPIN}{WAIT}</PersistentSequence>"
    play = Play(f"<ReactiveFallback><GoalUpdated/>{sequence}</ReactiveFallback>", goal=SE2())
    play.tick()
    assert play.tick(Spin=Answer(True)) is RUNNING
    assert (play.get("at"), set(play.open)) == (1, {"Wait"})
    play.tree.blackboard.set("goal", SE2(1.0))
    assert play.tick() is SUCCESS
    play.tick()
    assert (play.get("at"), set(play.open)) == (1, {"Wait"})
    play.tick(Wait=Answer(True))
    assert play.get("at") == 0


def test_a_paused_tree_runs_its_other_children_until_it_is_resumed() -> None:
    play = Play(
        "<PauseResumeController pause_service_name='pause' resume_service_name='resume'>"
        f"{SPIN}{WAIT}{BACK}<DriveOnHeading/></PauseResumeController>"
    )
    pause, resume = play.tree.calls["pause"], play.tree.calls["resume"]
    assert {topic.name for topic in play.tree.topics} == {"pause", "resume"}
    assert "does not run" in pause()
    assert (play.tick(), set(play.open)) == (RUNNING, {"Spin"})
    assert "is not paused" in resume()
    assert (pause(), pause()) == ("", "")
    assert (play.tick(), set(play.open)) == (RUNNING, {"BackUp"})
    assert play.tick(BackUp=True) is RUNNING
    assert (play.tick(), set(play.open)) == (RUNNING, {"Wait"})
    assert "is paused already" in pause()
    for _ in range(2):  # what runs while it is paused begins again
        assert play.tick(Wait=True) is RUNNING
        assert (play.tick(), set(play.open)) == (RUNNING, {"Wait"})
    assert resume() == ""
    assert (play.tick(), set(play.open)) == (RUNNING, {"DriveOnHeading"})
    assert play.tick(DriveOnHeading=True) is RUNNING
    assert (play.tick(), set(play.open)) == (RUNNING, {"Spin"})
    assert play.tick(Spin=True) is SUCCESS
    assert "does not run" in pause()


@pytest.mark.parametrize(("children", "status"), [(SPIN, RUNNING), (f"{SPIN}{NO}", FAILURE)])
def test_a_child_that_a_pause_lacks_is_left_out(children: str, status: Status) -> None:
    ports = "pause_service_name='/p' resume_service_name='/r'"
    play = Play(f"<PauseResumeController {ports}>{children}</PauseResumeController>")
    play.tick()
    assert play.tree.calls["/p"]() == ""
    assert [play.tick() for _ in range(2)] == [RUNNING, status]
    assert not play.open
