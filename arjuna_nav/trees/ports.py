"""Ports of tree nodes: texts of the XML, or `{entries}` of the blackboard, as values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2


class TreeError(ArjunaError):
    """A tree cannot be built of its XML, or cannot run; the message says where."""


def _number(value: Any) -> float:
    result = float(value)
    if math.isnan(result):
        raise ValueError(value)
    return result


def _whole(value: Any) -> int:
    return int(value) if not isinstance(value, float) or value.is_integer() else int(str(value))


def _truth(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    return {"true": True, "1": True, "false": False, "0": False}[str(value).lower()]


def _pose(value: Any) -> SE2:
    if not isinstance(value, SE2):
        raise ValueError(value)
    return value


def _poses(value: Any) -> tuple[SE2, ...]:
    if not isinstance(value, tuple) or not all(isinstance(each, SE2) for each in value):
        raise ValueError(value)
    return value


def _path(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        raise ValueError(value)
    return value


def _codes(value: Any) -> frozenset[int]:
    return frozenset(int(part) for part in str(value).replace(",", ";").split(";") if part.strip())


@dataclass(frozen=True)
class Kind:
    """What a port holds.

    Attributes:
        name: In words.
        convert: Makes it of a text or of the blackboard's value; raises where that is none.
        literal: Whether a text can be one.
    """

    name: str
    convert: Callable[[Any], Any]
    literal: bool = True


NUMBER = Kind("a number", _number)
WHOLE = Kind("a whole number", _whole)
TRUTH = Kind("true or false", _truth)
TEXT = Kind("a text", str)
CODES = Kind("error codes, as '100;102'", _codes)
POSE = Kind("a pose on the blackboard, as {goal}", _pose, literal=False)
POSES = Kind("poses on the blackboard, as {goals}", _poses, literal=False)
PATH = Kind("a path on the blackboard, as {path}", _path, literal=False)
ANY = Kind("anything", lambda value: value)

REQUIRED = object()
"""The default of a port that must be given."""


@dataclass(frozen=True)
class Port:
    """One port of a kind of nodes.

    Attributes:
        kind: What it holds.
        default: Its value where the XML does not name it, or the blackboard has no such entry.
        output: Whether the node writes it; then it must be an entry of the blackboard.
    """

    kind: Kind
    default: Any = REQUIRED
    output: bool = False


def entry(text: str) -> str | None:
    """Return the blackboard's entry that a port's text names, None where it is a value itself."""
    stripped = text.strip()
    return stripped[1:-1] if stripped.startswith("{") and stripped.endswith("}") else None


def checked(text: str, port: Port, where: str) -> None:
    """Refuse a port's text that can be no value of it.

    Raises:
        TreeError: It cannot.
    """
    if entry(text) is not None:
        return
    if port.output or not port.kind.literal:
        raise TreeError(f"{where} is '{text}'; valid: {port.kind.name}, in braces")
    converted(text, port.kind, where)


def converted(value: Any, kind: Kind, where: str) -> Any:
    """Return a port's value.

    Raises:
        TreeError: It is none of its kind.
    """
    try:
        return kind.convert(value)
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        shown = value if isinstance(value, (str, int, float)) else type(value).__name__
        raise TreeError(f"{where} is '{shown}'; valid: {kind.name}") from error


class Blackboard:
    """Entries by name; a subtree's entries may be those of the tree above under other names.

    Args:
        above: Of the tree above.
        renamed: The name above of each entry that is the same there.
        all_shared: Whether every other entry is the same above, under its own name.
    """

    def __init__(
        self,
        above: Blackboard | None = None,
        renamed: Mapping[str, str] | None = None,
        all_shared: bool = False,
    ) -> None:
        self._above = above
        self._renamed = dict(renamed or {})
        self._all_shared = all_shared
        self._values: dict[str, Any] = {}

    def _place(self, name: str) -> tuple[Blackboard, str]:
        """Return where an entry is; '@name' is an entry of the whole tree."""
        if name.startswith("@"):
            board = self
            while board._above is not None:
                board = board._above
            return board, name[1:]
        if self._above is not None and (name in self._renamed or self._all_shared):
            return self._above._place(self._renamed.get(name, name))
        return self, name

    def get(self, name: str) -> Any | None:
        """Return an entry, None where there is none."""
        board, key = self._place(name)
        return board._values.get(key)

    def set(self, name: str, value: Any) -> None:
        """Write an entry; None removes it."""
        board, key = self._place(name)
        if value is None:
            board._values.pop(key, None)
        else:
            board._values[key] = value
