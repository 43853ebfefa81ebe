"""Conditions in attributes, and the nodes of scripts and entries, as BehaviorTree.CPP's."""

from __future__ import annotations

import pytest

from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
SKIPPED = Status.SKIPPED
OK, NO, SPIN = "<AlwaysSuccess/>", "<AlwaysFailure/>", "<Spin/>"


@pytest.mark.parametrize(
    ("attributes", "status"),
    [
        ("_skipIf='a == 1'", SKIPPED),
        ("_skipIf='a == 2'", RUNNING),
        ("_successIf='a == 1'", SUCCESS),
        ("_failureIf='a == 1'", FAILURE),
        ("_failureIf='a == 1' _successIf='a == 1' _skipIf='a == 1'", FAILURE),
        ("_successIf='a == 1' _skipIf='a == 1'", SUCCESS),
        ("_while='a == 2'", SKIPPED),
        ("_while='a == 1'", RUNNING),
    ],
)
def test_conditions_decide_before_a_node_begins(attributes: str, status: Status) -> None:
    play = Play(f"<Spin {attributes}/>", a=1)
    assert play.tick() is status
    assert ("Spin" in play.open) is (status is RUNNING)


def test_a_running_node_is_stopped_by_while_alone() -> None:
    for attribute, status in (("_while='a == 1'", SKIPPED), ("_skipIf='a == 2'", RUNNING)):
        play = Play(f"<Spin {attribute}/>", a=1)
        play.tick()
        play.tree.blackboard.set("a", 2)
        assert play.tick() is status
        assert bool(play.withdrawn) is (status is SKIPPED)


@pytest.mark.parametrize(
    ("succeeds", "ran"), [(True, ["success", "post"]), (False, ["failure", "post"])]
)
def test_scripts_run_after_a_node_ended(succeeds: bool, ran: list[str]) -> None:
    play = Play(
        "<Spin _onSuccess=\"log := log .. ' success'\" _onFailure=\"log := log .. ' failure'\" "
        "_post=\"log := log .. ' post'\" _onHalted=\"log := log .. ' halted'\"/>",
        log="",
    )
    play.tick()
    play.tick(Spin=succeeds)
    assert str(play.get("log")).split() == ran


def test_a_script_runs_where_a_running_node_is_halted() -> None:
    play = Play(
        '<Timeout msec="150"><Spin _onHalted="halted += 1" _post="ended := 1"/></Timeout>', halted=0
    )
    while play.tick() is RUNNING:
        pass
    assert (play.get("halted"), play.get("ended")) == (1, None)


SKIP = '<AlwaysFailure _skipIf="true"/>'


@pytest.mark.parametrize(
    ("xml", "status"),
    [
        (f"<Sequence>{SKIP}{OK}</Sequence>", SUCCESS),
        (f"<Sequence>{SKIP}{SKIP}</Sequence>", SKIPPED),
        (f"<Fallback>{SKIP}{NO}</Fallback>", FAILURE),
        (f"<Fallback>{SKIP}{SKIP}</Fallback>", SKIPPED),
        (f"<ReactiveSequence>{SKIP}{OK}</ReactiveSequence>", SUCCESS),
        (f"<ReactiveFallback>{SKIP}{SKIP}</ReactiveFallback>", SKIPPED),
        (f"<Parallel>{SKIP}{OK}</Parallel>", SUCCESS),
        (f"<Parallel>{SKIP}{SKIP}</Parallel>", SKIPPED),
        (f"<ParallelAll>{SKIP}{OK}</ParallelAll>", SUCCESS),
        (f'<ParallelAll max_failures="2">{NO}{OK}</ParallelAll>', SUCCESS),
        (f'<ParallelAll max_failures="1">{NO}{OK}</ParallelAll>', FAILURE),
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
    assert Play(xml, a=1).tick() is status


@pytest.mark.parametrize(
    ("variable", "asked"), [("go", "Spin"), ("1", "Wait"), (1, "Wait"), ("x", "BackUp")]
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


def test_a_script_changes_entries() -> None:
    play = Play('<Script code="b := a * 2; a += 1"/>', a=1)
    assert play.tick() is SUCCESS
    assert (play.get("a"), play.get("b")) == (2, 2)


def test_sleep_lasts() -> None:
    play = Play('<Sleep msec="150"/>')
    assert [play.tick() for _ in range(6)] == [RUNNING, RUNNING, SUCCESS] * 2


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
