"""Regular expressions of clients: searched in bounded time, whatever the expression.

Python's own matcher tries one way after another and takes 2^n steps for `(a+)+$`. This one keeps
the set of all places that a part of the expression can end at (Thompson, 1968), so that a repeat
ends where its set no longer changes.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

from arjuna_core.errors import ArjunaError

if sys.version_info >= (3, 11):
    from re import _constants as codes
    from re import _parser as parser
else:
    import sre_constants as codes
    import sre_parse as parser

LONGEST = 256
"""Characters of an expression."""
_STEPS = 20_000  # of one search; far more than names need
_FLAGS = re.UNICODE.value
_KINDS: dict[str, Callable[[str], bool]] = {
    "DIGIT": str.isdecimal,
    "SPACE": str.isspace,
    "WORD": lambda char: char.isalnum() or char == "_",
}


class PatternError(ArjunaError, ValueError):
    """A text is no regular expression that can be searched."""


class Pattern:
    """A regular expression without back references, look-around or flags.

    Args:
        text: The expression, of Python's grammar.

    Raises:
        PatternError: It is none, is too long, or holds what cannot be searched in bounded time.
    """

    def __init__(self, text: str) -> None:
        if len(text) > LONGEST:
            raise PatternError(f"it has {len(text)} characters; at most {LONGEST} are valid")
        try:
            self._tree = parser.parse(text)
        except (re.error, RecursionError, OverflowError) as error:
            raise PatternError(str(error)) from error
        if self._tree.state.flags & ~_FLAGS:
            raise PatternError("it sets flags, which is not supported")
        self._steps = 0

    def found_in(self, text: str) -> bool:
        """Tell whether it matches anywhere in a text, as `re.search` does.

        Raises:
            PatternError: It takes too many steps, or holds what is not supported.
        """
        self._steps = 0
        return bool(self._ends(self._tree, text, set(range(len(text) + 1))))

    def _ends(self, tree: Any, text: str, starts: set[int]) -> set[int]:
        """Return where matches of a sequence end that begin at any of some places."""
        for code, value in tree:
            starts = self._step(code, value, text, starts)
        return starts

    def _step(self, code: Any, value: Any, text: str, starts: set[int]) -> set[int]:
        self._steps += 1
        if self._steps > _STEPS:
            raise PatternError("it takes too long; fewer repeats within repeats are valid")
        if code is codes.BRANCH:
            return set().union(*(self._ends(way, text, starts) for way in value[1]))
        if code is codes.SUBPATTERN and not value[1] and not value[2]:
            return self._ends(value[3], text, starts)
        if code in (codes.MAX_REPEAT, codes.MIN_REPEAT):
            least, most, tree = value
            return self._repeated(int(least), int(most), tree, text, starts)
        if code is codes.AT:
            return {at for at in starts if _stands(str(value), text, at)}
        return {at + 1 for at in starts if at < len(text) and _fits(code, value, text[at])}

    def _repeated(self, least: int, most: int, tree: Any, text: str, starts: set[int]) -> set[int]:
        """Return the ends of repeats: what needs `n` of them moves on or no longer changes."""
        for _ in range(least):
            ends = self._ends(tree, text, starts)
            if ends == starts:
                break
            starts = ends
        found = set(starts)
        for _ in range(least, most):
            starts = self._ends(tree, text, starts) - found
            if not starts:
                break
            found |= starts
        return found


def _fits(code: Any, value: Any, char: str) -> bool:
    """Tell whether one character is what a code asks for."""
    if code is codes.LITERAL:
        return ord(char) == int(value)
    if code is codes.NOT_LITERAL:
        return ord(char) != int(value)
    if code is codes.ANY:
        return char != "\n"
    if code is codes.RANGE:
        return bool(value[0] <= ord(char) <= value[1])
    if code is codes.CATEGORY:
        *_, absent, kind = ["", *str(value).removeprefix("CATEGORY_").split("_")]
        return _KINDS[kind](char) != (absent == "NOT")
    if code is codes.IN:
        negated = value[0][0] is codes.NEGATE
        return any(_fits(item[0], item[1], char) for item in value[negated:]) != negated
    raise PatternError(f"it holds {str(code).lower()}, which is not supported")


def _stands(where: str, text: str, at: int) -> bool:
    """Tell whether a place in a text is the one that an anchor asks for."""
    if where in ("AT_BEGINNING", "AT_BEGINNING_STRING"):
        return at == 0
    if where == "AT_END":
        return at == len(text) or (at == len(text) - 1 and text[at] == "\n")
    if where == "AT_END_STRING":
        return at == len(text)
    word = _KINDS["WORD"]
    before, after = at > 0 and word(text[at - 1]), at < len(text) and word(text[at])
    return (before != after) == (where == "AT_BOUNDARY")
