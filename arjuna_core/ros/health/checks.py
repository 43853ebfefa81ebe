"""One check for every message that enters: on a topic, in a service, in an action, from a file.

A message's type is taken apart once, into checks of its fields. Pure functions on anything with
ROS's generated fields; they import no ROS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from arjuna_core.ros.health import rules

_Check = Callable[[Any], str | None]
_NUMBERS = ("double", "float")
# fields that may hold inf or NaN: REP 117, an IMU's unmeasured parts, parameters judged one by one
_FREE = {
    "LaserScan": ("ranges", "intensities"),
    "Imu": ("orientation",),
    "Range": ("range",),
    "ParameterValue": ("double_value", "double_array_value"),
}
_CHECKS: dict[type[Any], tuple[tuple[str, Callable[[Any], Any], _Check], ...]] = {}


def problem_of(message: Any, now: float = 0.0) -> str | None:
    """Return why a message of any type cannot be used, or None.

    A measurement's stamp must not be far ahead of the time `now` [s]; 0 if that is unknown.
    """
    return rules.stamp_problem(message, now) or _problem(message)


def _problem(message: Any) -> str | None:
    kind = type(message)
    if kind not in _CHECKS:
        own = "_" if hasattr(message, "_check_fields") else ""  # rclpy's, behind properties
        _CHECKS[kind] = tuple(
            (path, attrgetter(own + path.replace(".", f".{own}")) if path else (lambda m: m), check)
            for path, check in _checks_of(message, "")
        )
    for path, value, check in _CHECKS[kind]:
        problem = check(value(message))
        if problem is not None:
            return f"{path}: {problem}" if path else problem
    return None


def _checks_of(message: Any, path: str) -> Iterator[tuple[str, _Check]]:
    """Yield dotted names of fields with their checks: of a message's fields, then of it all."""
    kind = type(message).__name__
    for name, field in message.get_fields_and_field_types().items():
        within = f"{path}.{name}".lstrip(".")
        check = _check_of(field, name)
        if name in _FREE.get(kind, ()):
            continue
        if check is not None:
            yield within, check
        elif "/" in field:
            yield from _checks_of(getattr(message, name), within)
    if kind in rules.RULES:
        yield path, rules.RULES[kind]


def _check_of(field: str, name: str = "") -> _Check | None:
    """Return the check of a value of a field's type; None of a message, or where all is valid."""
    if "[" in field or field.startswith("sequence<"):
        return _list_check(field.split("[")[0].removeprefix("sequence<").split(",")[0].rstrip(">"))
    if field.startswith(("string", "wstring")):
        return partial(_text_problem, rules.DOCUMENT if name in rules.DOCUMENTS else rules.TEXT)
    return _number_problem if field in _NUMBERS else None


def _list_check(item: str) -> _Check:
    most = rules.LONGEST.get(item, rules.ITEMS)
    check = _check_of(item) or (_problem if "/" in item else None)

    def problem(items: Any) -> str | None:
        if len(items) > most:
            return f"{len(items)} items; at most {most} are valid"
        if item in _NUMBERS:
            return _numbers_problem(items)
        if check is not None:
            for index, value in enumerate(items):
                found = check(value)
                if found is not None:
                    return f"item {index}: {found}"
        return None

    return problem


def _number_problem(value: float) -> str | None:
    if abs(value) <= rules.GREATEST:
        return None
    return f"{value} is {'too great' if math.isfinite(value) else 'not finite'}"


def _numbers_problem(items: Any) -> str | None:
    numbers = np.asarray(items, dtype=np.float64)
    if np.vdot(numbers, numbers) <= rules.GREATEST:  # as nearly always, at half the cost
        return None
    wrong = numbers[~(np.abs(numbers) <= rules.GREATEST)]  # NaN is not, either
    return _number_problem(float(wrong[0])) if len(wrong) else None


def _text_problem(most: int, text: str) -> str | None:
    return f"{len(text)} characters; at most {most} are valid" if len(text) > most else None
