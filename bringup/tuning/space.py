"""The search space of a tuning: parameters, each with its range, beside the value it has now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.config import check
from arjuna_core.errors import ConfigError, nearest
from arjuna_core.param import ParamInfo
from bringup.parameters.checking import over_shipped
from bringup.parameters.files import for_node
from bringup.parameters.listing import described
from bringup.stack import all_nodes

Known = Mapping[str, Mapping[str, tuple[Any, ParamInfo]]]
"""The value that every parameter has now and what is known of it, by node and name."""
Value = float | int | bool | str
_RANGE = {"low", "high", "log"}
_FORMS = "valid: {low, high}, {low, high, log: true} or a list of values"


@dataclass(frozen=True)
class Dimension:
    """A parameter that is searched, in a range or among some values.

    Attributes:
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
        """The name in the study and in tables."""
        return f"{self.node}: {self.key}"

    @property
    def whole(self) -> bool:
        """True where only whole numbers are valid."""
        return type(self.now) is int


def known_parameters(paths: Sequence[Path]) -> Known:
    """Return every parameter's value under some files, and what is known of it, by node.

    Raises:
        ArjunaError: A file cannot be used.
    """
    values = over_shipped(paths)
    return {
        spec.name: {
            one.key: (one.value, one.info)
            for one in described(spec.config, for_node(values, spec.name))
        }
        for spec in all_nodes()
    }


def dimensions_of(space: Any, known: Known) -> tuple[tuple[Dimension, ...], list[str]]:
    """Return a search space's dimensions, and everything that is wrong with it."""
    if not isinstance(space, dict) or not all(isinstance(v, dict) for v in space.values()):
        return (), ["'parameters' maps nodes to parameters, and these to ranges"]
    found: list[Dimension] = []
    problems: list[str] = []
    for node, ranges in space.items():
        if node not in known:
            problems.append(f"no node '{node}'; {nearest(str(node), known)}")
            continue
        for key, given in ranges.items():
            try:
                found.append(_dimension(str(node), str(key), given, known[node]))
            except ConfigError as error:
                problems += [f"{node}: {problem}" for problem in error.problems]
    if not found and not problems:
        problems.append("'parameters' names none")
    return tuple(found), problems


def _dimension(
    node: str, key: str, given: Any, known: Mapping[str, tuple[Any, ParamInfo]]
) -> Dimension:
    """Return a dimension.

    Raises:
        ConfigError: The parameter is unknown, or what is given is no range or values of it.
    """
    if key not in known:
        raise ConfigError(f"unknown parameter '{key}'; {nearest(key, known)}")
    now, info = known[key]
    if not isinstance(now, Value):
        raise ConfigError(f"'{key}' is {now!r} now: no number, truth or word to begin from")
    if isinstance(given, list):
        for value in given:
            check(key, value, type(now), info)
        if now not in given:
            raise ConfigError(f"'{key}' is {now!r} now, which its values leave out: list it too")
        return Dimension(node, key, now, info.unit, choices=tuple(given))
    if not isinstance(given, dict) or not {"low", "high"} <= set(given) <= _RANGE:
        raise ConfigError(f"'{key}' is no range; {_FORMS}")
    if isinstance(now, bool | str):
        raise ConfigError(f"'{key}' is {now!r}: list its values in place of a range")
    low, high = (check(key, given[end], type(now), info) for end in ("low", "high"))
    log = bool(given.get("log", False))
    if not low < high or (log and low <= 0):
        raise ConfigError(f"'{key}': low lies below high{', and above 0 for log' if log else ''}")
    if not low <= now <= high:
        raise ConfigError(f"'{key}' is {now} now, outside {low} to {high}: widen the range")
    return Dimension(node, key, now, info.unit, float(low), float(high), log)
