"""Scripts: BehaviorTree.CPP's expressions and assignments."""

from __future__ import annotations

import pytest

from arjuna_nav.trees.blackboard import Blackboard, TreeError
from arjuna_nav.trees.script import Script


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
