"""One check for every message that enters: on a topic, in a service, in an action, from a file.

A message's type is taken apart once, into checks of its fields. Pure functions on anything with
ROS's generated fields; they import no ROS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from operator import attrgetter
from typing import Any

import numpy as np

from arjuna_core.checks import limits
from arjuna_core.checks.rules import DOCUMENTS, MOST, RULES, rotation_problem, stamp_problem
from arjuna_core.timing import NANOSECONDS

_Check = Callable[[Any], str | None]
_PARAMETER_TYPES = 9  # rcl_interfaces/ParameterType, the last
_NUMBERS = ("double", "float")
# fields that may hold what is no number: REP 117, and unmeasured parts of an IMU's message
_FREE = {"LaserScan": ("ranges", "intensities"), "Imu": ("orientation",), "Range": ("range",)}
_CHECKS: dict[type[Any], tuple[_Check, ...]] = {}


def problem_of(message: Any, now: float = 0.0) -> str | None:
    """Return why a message cannot be used, or None.

    Args:
        message: Of any type.
        now: The time [s], which a measurement's stamp must not be far ahead of; 0 if unknown.
    """
    return stamp_problem(message, now) or _problem(message)


def call_problem(request: Any) -> str | None:
    """Return why a request of rclpy's own parameter services cannot be used, or None."""
    for name in ("parameters", "names", "prefixes"):
        count = len(getattr(request, name, ()))
        if count > limits.CALLS:
            return f"{name} has {count} items; at most {limits.CALLS} are valid"
    for each in getattr(request, "parameters", ()):
        if hasattr(each, "value") and each.value.type > _PARAMETER_TYPES:
            return f"{each.name}: type {each.value.type}; valid: 0 to {_PARAMETER_TYPES}"
    return None


def _problem(message: Any) -> str | None:
    kind = type(message)
    checks = _CHECKS.get(kind)
    if checks is None:
        checks = _CHECKS[kind] = tuple(_checks_of(message))
    for check in checks:
        problem = check(message)
        if problem is not None:
            return problem
    return None


def _checks_of(message: Any) -> Iterator[_Check]:
    """Yield the checks of a type: of its numbers, texts, times and rotations, lists, rules."""
    fields: dict[str, list[str]] = {}
    within: dict[str, list[str]] = {}
    _take_apart(message, "", fields, within)
    own = "_" if hasattr(message, "_check_fields") else ""  # rclpy's, behind properties
    numbers = [path for kind in _NUMBERS for path in fields.pop(kind, ())]
    if numbers:
        yield _numbers_check(numbers, own)
    if "string" in fields:
        yield _check_of_each(fields.pop("string"), own, _text_problem)
    for kind, problem in _SPECIAL.items():
        if kind in fields:
            yield _check_of_each(fields.pop(kind), own, _below(problem))
    for kind, paths in fields.items():
        yield _check_of_each(paths, own, _list_problem(kind))
    for kind, paths in within.items():
        if kind in RULES:
            yield _check_of_each(paths, own, _below(RULES[kind]))


def _take_apart(
    message: Any, prefix: str, fields: dict[str, list[str]], within: dict[str, list[str]]
) -> None:
    """Note the dotted names of a message's fields by type, and of the messages within by name."""
    within.setdefault(type(message).__name__, []).append(prefix.rstrip("."))
    free = _FREE.get(type(message).__name__, ())
    for name, kind in message.get_fields_and_field_types().items():
        path = prefix + name
        if name in free:
            continue
        if "[" in kind or kind.startswith("sequence<"):
            item = kind.split("[")[0].removeprefix("sequence<").split(",")[0].rstrip(">")
            fields.setdefault(f"{item}[]", []).append(path)
        elif "/" in kind and kind not in _SPECIAL:
            _take_apart(getattr(message, name), f"{path}.", fields, within)
        elif kind in _NUMBERS or kind in _SPECIAL:
            fields.setdefault(kind, []).append(path)
        elif kind.startswith(("string", "wstring")):
            fields.setdefault("string", []).append(path)


def _values(paths: list[str], own: str) -> Callable[[Any], tuple[Any, ...]]:
    """Return what returns the values of fields, which stand behind names with a prefix."""
    if paths == [""]:
        return lambda message: (message,)
    get = attrgetter(*(".".join(own + name for name in path.split(".")) for path in paths))
    return get if len(paths) > 1 else lambda message: (get(message),)


def _check_of_each(
    paths: list[str], own: str, problem_of_field: Callable[[str, Any], str | None]
) -> _Check:
    """Return the check of some fields, one by one."""
    values = _values(paths, own)

    def check(message: Any) -> str | None:
        for path, value in zip(paths, values(message), strict=True):
            problem = problem_of_field(path, value)
            if problem is not None:
                return problem
        return None

    return check


def _below(problem_of_value: _Check) -> Callable[[str, Any], str | None]:
    """Return a check of a value that names the field that it is of."""

    def problem(path: str, value: Any) -> str | None:
        found = problem_of_value(value)
        return f"{path}: {found}" if found and path else found

    return problem


def _numbers_check(paths: list[str], own: str) -> _Check:
    """Return the check of all numbers at once."""
    values = _values(paths, own)

    def check(message: Any) -> str | None:
        if sum(map(abs, values(message))) <= limits.GREATEST:
            return None
        for path, value in zip(paths, values(message), strict=True):
            if not abs(value) <= limits.GREATEST:
                return f"{path} is {value}, {_fault(value)}"
        return "its numbers are too great"

    return check


def _fault(value: float) -> str:
    return "too great" if math.isfinite(value) else "not finite"


def _text_problem(path: str, text: str) -> str | None:
    if len(text) > limits.TEXT:
        most = limits.DOCUMENT if path.split(".")[-1] in DOCUMENTS else limits.TEXT
        if len(text) > most:
            return f"{path} has {len(text)} characters; at most {most} are valid"
    return None


def _duration_problem(value: Any) -> str | None:
    if value.nanosec < NANOSECONDS:
        return None
    return f"{value.nanosec} ns; valid: less than {NANOSECONDS}"


def _time_problem(value: Any) -> str | None:
    return _duration_problem(value) or (f"is {value.sec} s" if value.sec < 0 else None)


_SPECIAL: dict[str, _Check] = {
    "builtin_interfaces/Time": _time_problem,
    "builtin_interfaces/Duration": _duration_problem,
    "geometry_msgs/Quaternion": rotation_problem,
}


def _list_problem(kind: str) -> Callable[[str, Any], str | None]:
    """Return the check of a list of a type."""
    most, item = MOST.get(kind, limits.ITEMS), kind.removesuffix("[]")
    check: _Check = (
        _many_numbers_problem
        if item in _NUMBERS
        else _many_texts_problem
        if item in ("string", "wstring")
        else _many_problem(_SPECIAL.get(item, _problem))
        if "/" in item
        else lambda items: None
    )

    def problem(path: str, items: Any) -> str | None:
        if len(items) > most:
            return f"{path} has {len(items)} items; at most {most} are valid"
        found = check(items)
        return None if found is None else f"{path}{found}"

    return problem


def _many_numbers_problem(items: Any) -> str | None:
    numbers = np.asarray(items, dtype=np.float64)
    if np.vdot(numbers, numbers) <= limits.GREATEST:  # as nearly always, at half the cost
        return None
    if len(numbers) and not np.abs(numbers).max() <= limits.GREATEST:  # NaN is not, either
        worst = float(numbers[~(np.abs(numbers) <= limits.GREATEST)][0])
        return f": one is {worst}, {_fault(worst)}"
    return None


def _many_texts_problem(items: Any) -> str | None:
    longest = max(map(len, items), default=0)
    if longest <= limits.TEXT:
        return None
    return f": one has {longest} characters; at most {limits.TEXT} are valid"


def _many_problem(problem_of_item: _Check) -> _Check:
    """Return the check of each item of a list."""

    def check(items: Any) -> str | None:
        for index, item in enumerate(items):
            problem = problem_of_item(item)
            if problem is not None:
                return f"[{index}]: {problem}"
        return None

    return check
