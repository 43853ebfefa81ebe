"""Tree nodes, their ports and scripts."""

from __future__ import annotations

import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.blackboard import Blackboard, TreeError
from arjuna_nav.trees.node import Status
from arjuna_nav.trees.ports import entry
from arjuna_nav.trees.script import Script
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
SKIPPED = Status.SKIPPED
OK, NO = "<AlwaysSuccess/>", "<AlwaysFailure/>"


def test_the_log_says_what_changed() -> None:
    play = Play(f'<Sequence name="all">{OK}{NO}</Sequence>')
    play.tick()
    logged = [(c.node, c.uid, c.before, c.after) for c in play.tree.take_changes()]
    assert logged[:3] == [
        ("all", 1, "IDLE", "RUNNING"),
        ("AlwaysSuccess", 2, "IDLE", "SUCCESS"),
        ("AlwaysFailure", 3, "IDLE", "FAILURE"),
    ]
    assert ("all", 1, "RUNNING", "FAILURE") in logged
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


def test_what_groot_leaves_empty_is_not_given() -> None:
    play = Play('<ComputePathToPose goal="{goal}" start="" path="" error_code_id=""/>', goal=SE2())
    assert play.tick() is RUNNING
    assert play.tick(ComputePathToPose=True) is SUCCESS
    nothing = Play('<ComputePathToPose goal=""/>')
    with pytest.raises(TreeError, match="port 'goal'"):
        nothing.tick()


@pytest.mark.parametrize(
    ("text", "name"), [("{goal}", "goal"), (" {a_b} ", "a_b"), ("{goal", None), ("goal}", None)]
)
def test_braces_on_both_sides_name_an_entry(text: str, name: str | None) -> None:
    assert entry(text) == name


@pytest.mark.parametrize(
    ("node", "entries", "says"),
    [
        ('<TruncatePath input_path="{path}" output_path="{o}"/>', {"path": "text"}, "a path"),
        ('<GoalReached goal="{goal}"/>', {"goal": (1, 2)}, "a pose"),
        ('<GoalReached goal="{g}" goal_reached_tol="{t}"/>', {"g": SE2(), "t": "nan"}, "a number"),
        ('<Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>', {"n": 1.5}, "a whole number"),
    ],
)
def test_another_kind_is_refused(node: str, entries: dict[str, object], says: str) -> None:
    play = Play(node, **entries)
    with pytest.raises(TreeError, match=says):
        play.tick()


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


def board(**entries: object) -> Blackboard:
    made = Blackboard()
    for name, value in entries.items():
        made.set(name, value)
    return made


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("7 - 2 - 1", 4),
        ("8 / 4 / 2", 1.0),
        ("-a + 1", -2),
        ("0xFF & 0x0F | 0x10", 0x1F),
        ("6 ^ 3", 5),
        ("~0", -1),
        ("1.5e1", 15.0),
        ("'a' .. 1", "a1"),
        ("'a' + 'b'", "ab"),
        ("a == 3", True),
        ("a != 3", False),
        ("1 < a <= 3", True),
        ("1 < a < 3", False),
        ("text == 'idle'", True),
        ("text != 'idle' || a > 2", True),
        ("number == 42", True),
        ("!flag && a >= 4 || flag", True),
        ("!(flag && a > 5)", True),
        ("false || false", False),
        ("a > 2 ? 'far' : 'near'", "far"),
        ("a < 2 ? 1 : a < 3 ? 2 : 3", 3),
        ("true ? 1 : nothing", 1),
        ("flag || nothing", True),
        ("1; 2;", 2),
    ],
)
def test_the_value_of_an_expression(text: str, value: object) -> None:
    entries = board(a=3, text="idle", number="42", flag=True)
    found = Script(text).run(entries)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x := 5", 5),
        ("a = a + 1", 4),
        ("a += 2", 5),
        ("a -= 2", 1),
        ("a *= 2", 6),
        ("a /= 2", 1.5),
        ("x := 'go'; x += '!'", "go!"),
        ("@x := 1", 1),
    ],
)
def test_entries_are_written(text: str, value: object) -> None:
    entries = board(a=3)
    Script(text).run(entries)
    assert entries.get("a" if text.startswith("a") else "x") == value


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a >", "it ends too early"),
        ("", "it ends too early"),
        ("a b", "unexpected 'b'"),
        ("(1", "it ends too early"),
        ("1 ? 2", "it ends too early"),
        ("a $ b", "unexpected '$ b'"),
        ("1 := 2", "unexpected ':='"),
        ("import os", "unexpected 'os'"),
        ("f(1)", r"unexpected '\('"),
    ],
)
def test_a_text_that_is_no_script_is_refused(text: str, says: str) -> None:
    with pytest.raises(TreeError, match=says.replace("$", r"\$")):
        Script(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("none > 1", "none is not on the blackboard"),
        ("none = 1", "none is not on the blackboard"),
        ("none += 1", "none is not on the blackboard"),
        ("text + 1", "'idle' is no number"),
        ("text", "'idle' is no number"),
        ("1 / 0", "division by zero"),
    ],
)
def test_values_that_do_not_fit_are_named(text: str, says: str) -> None:
    with pytest.raises(TreeError, match=says):
        Script(text).holds(board(text="idle"))
