"""Ports of tree nodes: texts of the XML, or `{entries}` of the blackboard, as values."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from arjuna_core.se2 import SE2, yaw_of
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.script import Script


def _number(value: Any) -> float:
    result = float(value)
    if math.isnan(result):
        raise ValueError(value)
    return result


def _whole(value: Any) -> int:
    return int(value) if not isinstance(value, float) or value.is_integer() else int(str(value))


def _truth(value: Any) -> bool:
    return {"true": True, "1": True, "false": False, "0": False}[str(value).lower()]


def _poses(value: Any) -> tuple[SE2, ...]:
    """Return poses, or those of a text as Nav2 reads it: nine parts each, in the frame map."""
    if isinstance(value, str):
        parts = value.split(";")
        if len(parts) % 9:
            raise ValueError(value)
        return tuple(_written_pose(parts[at : at + 9]) for at in range(0, len(parts), 9))
    if not isinstance(value, tuple) or not all(isinstance(each, SE2) for each in value):
        raise ValueError(value)
    return value


def _written_pose(parts: list[str]) -> SE2:
    if parts[1].strip().lstrip("/") != "map":
        raise ValueError(parts[1])
    x, y, _, *quaternion = (float(part) for part in parts[2:])
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(parts)
    return SE2(x, y, yaw_of(*quaternion))


def _pose(value: Any) -> SE2:
    (pose,) = (value,) if isinstance(value, SE2) else _poses(value)
    if not isinstance(pose, SE2):
        raise ValueError(value)
    return pose


def _only(kind: type[Any]) -> Callable[[Any], Any]:
    """Return a function that passes values of one type and refuses others."""

    def checked(value: Any) -> Any:
        if not isinstance(value, kind):
            raise ValueError(value)
        return value

    return checked


def _codes(value: Any) -> frozenset[int]:
    return frozenset(int(part) for part in str(value).replace(",", ";").split(";") if part.strip())


@dataclass(frozen=True)
class Kind:
    """The values of a port.

    Attributes:
        convert: Makes one of a text or of the blackboard's value; raises where that is none.
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
STATUS = Kind(
    "SUCCESS, FAILURE or SKIPPED",
    {status: status for status in ("SUCCESS", "FAILURE", "SKIPPED")}.__getitem__,
)
SCRIPT = Kind("a script", lambda value: value if isinstance(value, Script) else Script(str(value)))
_WRITTEN = "'stamp;map;x;y;z;qx;qy;qz;qw'"
POSE = Kind(f"a pose on the blackboard, as {{goal}}, or {_WRITTEN}", _pose)
POSES = Kind(f"poses on the blackboard, as {{goals}}, or {_WRITTEN} each", _poses)
PATH = Kind("a path on the blackboard, as {path}", _only(np.ndarray), literal=False)
ANY = Kind("anything", lambda value: value)

REQUIRED = object()
"""The default of a port that must be given."""


@dataclass
class Port:
    """One port of a kind of nodes: an attribute of its class that is read from the node's XML.

    Attributes:
        default: Its value where the XML does not name it, or the blackboard has no such entry.
        field: The field of the server's request that it fills, or of the result that it takes;
            empty: none in a request, the port's own name in a result.
        output: Whether the node writes it; then it must be an entry of the blackboard.
        name: In the XML; that of the attribute where it is empty.
    """

    kind: Kind
    default: Any = REQUIRED
    field: str = ""
    output: bool = False
    name: str = ""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        self.name = self.name or name

    def __get__(self, node: Any, owner: type[Any]) -> Any:
        return self if node is None else node.get(self.name)

    def __set__(self, node: Any, value: Any) -> None:
        node.put(self.name, value)


def entry(text: str) -> str | None:
    """Return the blackboard's entry that a port's text names, None where it is a value itself.

    BehaviorTree.CPP 3 takes `${entry}`, too.
    """
    stripped = text.strip()
    stripped = stripped.removeprefix("$") if stripped.startswith("${") else stripped
    return stripped[1:-1] if stripped.startswith("{") and stripped.endswith("}") else None


def literal(text: str, port: Port, where: str) -> Any:
    """Return the value of a port's text that names no entry.

    Raises:
        TreeError: It can be no value of the port.
    """
    if port.output or not port.kind.literal:
        raise TreeError(f"{where} is '{text}'; valid: {port.kind.name}, in braces")
    try:
        return port.kind.convert(text)
    except NOT_OF_KIND as error:
        raise mismatch(text, port.kind, where, error) from error


NOT_OF_KIND = (ValueError, KeyError, TypeError, OverflowError, TreeError)
"""The errors of `Kind.convert`."""


def mismatch(value: Any, kind: Kind, where: str, error: Exception) -> TreeError:
    """Return the error of a port's value that is not of its kind."""
    if isinstance(error, TreeError):
        return TreeError(f"{where}: {error}")
    shown = value if isinstance(value, (str, int, float)) else type(value).__name__
    return TreeError(f"{where} is '{shown}'; valid: {kind.name}")
