"""Messages filled from what a person types: YAML."""

from __future__ import annotations

import array
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import yaml
from rosidl_parser import definition

from bringup.ros2.errors import Ros2Error
from bringup.ros2.types import nested_class
from bringup.ros2.values import fields_of, is_message


def parse(text: str) -> Any:
    """Return what a person typed as YAML.

    Raises:
        Ros2Error: It is no YAML.
    """
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise Ros2Error(f"The passed value is no YAML: {error}") from error


def fill(
    message: Any, values: Any, says: str = "Failed to populate field: {}"
) -> list[Callable[[Any], None]]:
    """Set fields of a message.

    Args:
        values: A dictionary of its fields, as `parse` returns it.
        says: What is said of an error.

    Returns:
        What sets the stamps that were given as `now`, or `auto` for a whole header, to a time.

    Raises:
        Ros2Error: A field does not exist, or a value is of the wrong type.
    """
    stamps: list[Callable[[Any], None]] = []
    try:
        _fill(message, values, stamps)
    except (AttributeError, TypeError, ValueError, AssertionError, OverflowError) as error:
        raise Ros2Error(says.format(error)) from error
    return stamps


def _fill(message: Any, values: Any, stamps: list[Callable[[Any], None]]) -> None:
    if not isinstance(values, dict):
        kind = type(values).__name__
        raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {kind}")
    kinds = {name: kind for name, _, kind in fields_of(message)} if is_message(message) else {}
    for name, value in values.items():
        field = getattr(message, name)
        if not is_message(field):
            setattr(message, name, _converted(field, kinds.get(name), value, stamps))
        elif value == "auto" and type(field).__name__ == "Header":
            stamps.append(partial(setattr, field, "stamp"))
        elif value == "now" and type(field).__name__ == "Time":
            stamps.append(partial(setattr, message, name))
        else:
            _fill(field, value, stamps)


def _converted(field: Any, kind: Any, value: Any, stamps: list[Callable[[Any], None]]) -> Any:
    """Return a value as the type of the field that it goes to."""
    if isinstance(field, array.array):
        return array.array(field.typecode, value)
    if isinstance(field, np.ndarray):
        return np.array(value, dtype=field.dtype)
    if isinstance(field, bytes) and isinstance(value, int):
        return bytes([value])
    plain = _as(type(field), value, stamps)
    item = getattr(kind, "value_type", None)
    if not isinstance(item, definition.NamespacedType):
        return plain
    made = [nested_class(item)() for _ in plain]
    for message, values in zip(made, plain, strict=True):
        _fill(message, values, stamps)
    return made


def _as(kind: type[Any], value: Any, stamps: list[Callable[[Any], None]]) -> Any:
    """Return a value as a plain type; ros2cli takes any other value for a dictionary of fields."""
    if type(value) is kind:
        return value
    try:
        return kind(value)
    except TypeError:
        made = kind()
        _fill(made, value, stamps)
        return made
