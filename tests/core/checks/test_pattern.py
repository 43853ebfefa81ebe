"""Claims: a client's expression finds what Python's finds, in bounded time."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest

from arjuna_core.checks.pattern import LONGEST, Pattern, PatternError

ATOMS = ("a", "b", ".", "[ab]", "[^a]", r"\w", r"\d", "1", "(a|bb)", "(?:b1)", r"\b", "")
REPEATS = ("", "", "*", "+", "?", "{2}", "{1,3}", "*?", "{0,2}")
SLOW = ("(a+)+$", "(a*)*b", "(a|a)*b", "(a|aa)+$", "a*a*a*a*a*a*b", "(((a+)+)+)+b", "(.*){50}b")


def drawn(rng: np.random.Generator, depth: int = 0) -> str:
    """Return an expression that Python takes, of a few parts."""
    parts = []
    for _ in range(int(rng.integers(1, 4))):
        atom = str(rng.choice(ATOMS))
        if depth < 2 and rng.random() < 0.3:
            atom = f"({drawn(rng, depth + 1)})"
        parts.append(atom + (str(rng.choice(REPEATS)) if atom not in ("", r"\b") else ""))
    text = "".join(parts)
    ends = rng.integers(0, 8)
    return f"^{text}" if ends == 0 else f"{text}$" if ends == 1 else text


@pytest.mark.parametrize("seed", range(300))
def test_it_finds_what_python_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    expression = drawn(rng)
    for _ in range(10):
        text = "".join(rng.choice(list("ab1 "), int(rng.integers(0, 9))))
        expected = re.search(expression, text) is not None
        assert Pattern(expression).found_in(text) == expected, (expression, text)


@pytest.mark.parametrize("expression", [r"\Aab", r"b\Z", r"\Z", "b$", "^$", r"\Bb", r"a\B"])
@pytest.mark.parametrize("text", ["", "ab", "ab\n", "bab", "a b", "\n"])
def test_anchors_stand_where_python_s_do(expression: str, text: str) -> None:
    assert Pattern(expression).found_in(text) == (re.search(expression, text) is not None)


def test_the_longest_expression_is_searched() -> None:
    assert Pattern("a" * LONGEST).found_in("a" * LONGEST)


@pytest.mark.parametrize("expression", SLOW)
def test_what_takes_python_for_ever_ends(expression: str) -> None:
    begun = time.process_time()
    assert not Pattern(expression).found_in("a" * 200 + "!")
    assert time.process_time() - begun < 0.5


@pytest.mark.parametrize(
    ("expression", "problem"),
    [
        ("[", "unterminated character set"),
        ("(" * 200, "missing \\)"),
        ("a" * (LONGEST + 1), f"it has {LONGEST + 1} characters"),
        (r"(a)\1", "groupref"),
        ("(?=a)", "assert"),
        ("(?i)a", "flags"),
        ("a{99999999999}", "too large"),
    ],
)
def test_what_cannot_be_searched_is_named(expression: str, problem: str) -> None:
    with pytest.raises(PatternError, match=problem):
        Pattern(expression).found_in("aaa")


def test_a_count_beyond_the_text_ends_at_once() -> None:
    begun = time.process_time()
    assert not Pattern("(a{60000}){60000}").found_in("a" * 100)
    assert Pattern("(a?){60000}").found_in("a" * 100)
    assert time.process_time() - begun < 0.5
