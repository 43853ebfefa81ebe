"""One check for every message that enters: on a topic, in a service, in an action, from a file.

Pure functions on anything with ROS's generated fields; they import no ROS.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from arjuna_core.checks import limits
from arjuna_core.checks.rules import DOCUMENTS, MOST, RULES, rotation_problem, stamp_problem
from arjuna_core.checks.structure import DURATION, QUATERNION, TIME, Part, Structure, structure_of

_NANO = 1_000_000_000
_PARAMETER_TYPES = 9  # rcl_interfaces/ParameterType, the last
_STRUCTURES: dict[type[Any], Structure] = {}


def problem_of(message: Any, now: float = 0.0) -> str | None:
    """Return why a message cannot be used, or None.

    Args:
        message: Of any type.
        now: The time [s], which a measurement's stamp must not be far ahead of; 0 if unknown.
    """
    return unread(message) or stamp_problem(message, now) or _problem(message)


def unread(message: Any) -> str | None:
    """Return why the lists of a message were not read, or None if they were."""
    return getattr(message, "refusal", None)


def untyped(request: Any) -> str | None:
    """Return which of the parameters of a request to set some is of no type that there is."""
    for each in getattr(request, "parameters", ()):
        if hasattr(each, "value") and each.value.type > _PARAMETER_TYPES:
            return f"{each.name}: type {each.value.type}; valid: 0 to {_PARAMETER_TYPES}"
    return None


def _problem(message: Any) -> str | None:
    kind = type(message)
    structure = _STRUCTURES.get(kind)
    if structure is None:
        structure = _STRUCTURES[kind] = structure_of(message, RULES)
    return (
        _numbers_problem(structure.floats, message)
        or _texts_problem(structure.texts, message)
        or _specials_problem(structure.specials, message)
        or _sequences_problem(structure.sequences, message)
        or _rules_problem(structure.ruled, message)
    )


def _rules_problem(parts: tuple[Part, ...], message: Any) -> str | None:
    for part in parts:
        rule = RULES[part.kind]
        for path, value in zip(part.paths, part.values(message), strict=True):
            problem = rule(value)
            if problem is not None:
                return f"{path}: {problem}" if path else problem
    return None


def _numbers_problem(part: Part, message: Any) -> str | None:
    values = part.values(message)
    if sum(map(abs, values)) <= limits.GREATEST:
        return None
    for path, value in zip(part.paths, values, strict=True):
        if not abs(value) <= limits.GREATEST:
            return f"{path} is {value}, {_fault(value)}"
    return "its numbers are too great"


def _fault(value: float) -> str:
    return "too great" if math.isfinite(value) else "not finite"


def _texts_problem(part: Part, message: Any) -> str | None:
    for path, text in zip(part.paths, part.values(message), strict=True):
        if len(text) > limits.TEXT:
            most = limits.DOCUMENT if path.split(".")[-1] in DOCUMENTS else limits.TEXT
            if len(text) > most:
                return f"{path} has {len(text)} characters; at most {most} are valid"
    return None


def _specials_problem(parts: tuple[Part, ...], message: Any) -> str | None:
    for part in parts:
        for path, value in zip(part.paths, part.values(message), strict=True):
            problem = _special_problem(part.kind, value)
            if problem is not None:
                return f"{path}: {problem}"
    return None


def _special_problem(kind: str, value: Any) -> str | None:
    if kind == QUATERNION:
        return rotation_problem(value)
    if kind in (TIME, DURATION) and value.nanosec >= _NANO:
        return f"{value.nanosec} ns; valid: less than {_NANO}"
    if kind == TIME and value.sec < 0:
        return f"is {value.sec} s"
    return None


def _sequences_problem(parts: tuple[Part, ...], message: Any) -> str | None:
    for part in parts:
        most = MOST.get(part.kind, limits.ITEMS)
        for path, items in zip(part.paths, part.values(message), strict=True):
            if len(items) > most:
                return f"{path} has {len(items)} items; at most {most} are valid"
            problem = _items_problem(part.kind, items)
            if problem is not None:
                return f"{path}{problem}"
    return None


def _items_problem(kind: str, items: Any) -> str | None:
    """Return what is wrong with an item, after its index."""
    if kind in ("double[]", "float[]"):
        numbers = np.asarray(items, dtype=np.float64)
        if np.vdot(numbers, numbers) <= limits.GREATEST:  # as nearly always, told at half the cost
            return None
        if len(numbers) and not np.abs(numbers).max() <= limits.GREATEST:  # NaN is not, either
            worst = float(numbers[~(np.abs(numbers) <= limits.GREATEST)][0])
            return f": one is {worst}, {_fault(worst)}"
    elif kind in ("string[]", "wstring[]"):
        longest = max(map(len, items), default=0)
        if longest > limits.TEXT:
            return f": one has {longest} characters; at most {limits.TEXT} are valid"
    elif "/" in kind:
        for index, item in enumerate(items):
            problem = _item_problem(kind, item)
            if problem is not None:
                return f"[{index}]: {problem}"
    return None


def _item_problem(kind: str, item: Any) -> str | None:
    bare = kind.removesuffix("[]")
    if bare in (TIME, DURATION, QUATERNION):
        return _special_problem(bare, item)
    return _problem(item)
