"""What a tuning searches: parameters, each with its range, beside the value it has now."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arjuna_core.errors import nearest
from arjuna_core.param import ParamInfo

Known = Mapping[str, Mapping[str, tuple[Any, ParamInfo]]]
"""The value that every parameter has now and what is known of it, by node and name."""
Value = float | int | bool | str
_RANGE = {"low", "high", "log"}
_FORMS = "valid: {low, high}, {low, high, log: true} or a list of values"


@dataclass(frozen=True)
class Dimension:
    """A parameter that is searched, in a range or among some values.

    Attributes:
        node: The node's name.
        key: The parameter's.
        now: The value it has now.
        unit: Its unit, or "".
        low: Least value to try; NaN for choices.
        high: Greatest value to try; NaN for choices.
        log: Whether factors count, not differences.
        choices: The values to try, in place of a range.
    """

    node: str
    key: str
    now: Value
    unit: str
    low: float = float("nan")
    high: float = float("nan")
    log: bool = False
    choices: tuple[Value, ...] = ()

    @property
    def name(self) -> str:
        """What it is called in the study and in tables."""
        return f"{self.node}: {self.key}"

    @property
    def whole(self) -> bool:
        """Whether only whole numbers are valid."""
        return type(self.now) is int


def dimensions_of(space: Any, known: Known) -> tuple[tuple[Dimension, ...], list[str]]:
    """Return a search space's dimensions, and everything that is wrong with it.

    Args:
        space: `{node: {parameter: range or list of values}}`, as a file has it.
        known: The parameters there are.
    """
    if not isinstance(space, dict) or not all(isinstance(v, dict) for v in space.values()):
        return (), ["'parameters' maps nodes to parameters, and these to ranges"]
    found: list[Dimension] = []
    problems: list[str] = []
    for node, ranges in space.items():
        if node not in known:
            problems.append(f"no node '{node}'; {nearest(str(node), known)}")
            continue
        for key, given in ranges.items():
            result = _dimension(str(node), str(key), given, known[node])
            if isinstance(result, str):
                problems.append(f"{node}: {result}")
            else:
                found.append(result)
    if not found and not problems:
        problems.append("'parameters' names none")
    return tuple(found), problems


def _dimension(
    node: str, key: str, given: Any, known: Mapping[str, tuple[Any, ParamInfo]]
) -> Dimension | str:
    """Return a dimension, or what is wrong with it."""
    if key not in known:
        return f"unknown parameter '{key}'; {nearest(key, known)}"
    now, info = known[key]
    if not isinstance(now, Value):
        return f"'{key}' is {now!r} now: no number, truth or word to begin from"
    if isinstance(given, list):
        return _among(Dimension(node, key, now, info.unit, choices=tuple(given)), info)
    if isinstance(given, dict) and {"low", "high"} <= set(given) <= _RANGE:
        return _between(node, key, now, info, given)
    return f"'{key}' is no range; {_FORMS}"


def _among(dimension: Dimension, info: ParamInfo) -> Dimension | str:
    key, now, choices = dimension.key, dimension.now, dimension.choices
    kinds = (int, float) if type(now) is float else (type(now),)
    if any(type(v) not in kinds for v in choices):
        return f"'{key}' is {now!r}: its values must be of that kind, not {list(choices)}"
    unfit = [v for v in choices if not _valid(v, info)]
    if unfit:
        return f"'{key}' cannot be {', '.join(map(str, unfit))}; valid: {_bounds(info)}"
    if now not in choices:
        return f"'{key}' is {now!r} now, which its values leave out: list it too"
    return dimension


def _between(
    node: str, key: str, now: Value, info: ParamInfo, given: Mapping[str, Any]
) -> Dimension | str:
    low, high, log = given["low"], given["high"], given.get("log", False)
    if isinstance(now, bool | str):
        return f"'{key}' is {now!r}: list its values in place of a range"
    kinds = (int, float) if type(now) is float else (int,)
    if any(type(v) not in kinds for v in (low, high)):
        return f"'{key}': low and high are {'' if float in kinds else 'whole '}numbers"
    if not low < high or (log and low <= 0):
        return f"'{key}': low lies below high{', and above 0 for log' if log else ''}"
    if not (_valid(low, info) and _valid(high, info)):
        return f"'{key}' reaches from {low} to {high}; valid: {_bounds(info)}"
    if not low <= now <= high:
        return f"'{key}' is {now} now, outside {low} to {high}: widen the range"
    return Dimension(node, key, now, info.unit, float(low), float(high), bool(log))


def _valid(value: Value, info: ParamInfo) -> bool:
    if info.choices:
        return value in info.choices
    if isinstance(value, bool | str):
        return True
    low, high = info.bounds
    return low <= value <= high


def _bounds(info: ParamInfo) -> str:
    if info.choices:
        return ", ".join(map(str, info.choices))
    low, high = info.bounds
    return f"{low:g} to {high:g}{' ' if info.unit else ''}{info.unit}"
