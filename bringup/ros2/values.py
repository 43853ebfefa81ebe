"""Messages as plain values, as YAML and CSV, and filled from YAML."""

from __future__ import annotations

import array
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import yaml
from rosidl_parser import definition

from bringup.ros2.errors import Ros2Error
from bringup.ros2.types import nested_class

_WIDTH = 2**31 - 1  # no line is broken


@dataclass(frozen=True)
class Abridge:
    """What is left out of a message.

    Attributes:
        length: Where arrays, bytes and strings are cut; None for nowhere.
        no_arrays: Whether arrays are only described.
        no_strings: Whether strings are only described.
    """

    length: int | None = None
    no_arrays: bool = False
    no_strings: bool = False


WHOLE = Abridge()


def is_message(value: Any) -> bool:
    """Tell whether a value is a message."""
    return hasattr(value, "get_fields_and_field_types")


def to_plain(message: Any, abridge: Abridge = WHOLE) -> dict[str, Any]:
    """Return a message as a dictionary of plain values."""
    fields = message.get_fields_and_field_types()
    return {
        name: _plain(getattr(message, name), kind, abridge)
        for name, kind in zip(fields, message.SLOT_TYPES, strict=True)
    }


def _plain(value: Any, kind: Any, abridge: Abridge) -> Any:
    if is_message(value):
        return to_plain(value, abridge)
    if isinstance(value, (str, bytes)):
        text = value if isinstance(value, str) else value.decode("latin-1")
        if abridge.no_strings and isinstance(value, str):
            return f"<string length: <{len(text)}>>"
        return text if _fits(text, abridge) else text[: abridge.length] + "..."
    if isinstance(value, np.number):
        return value.item()
    if not isinstance(value, (list, tuple, set, array.array, np.ndarray)):
        return value
    if abridge.no_arrays and kind is not None:
        return _described(value, kind)
    items = [_plain(item, None, abridge) for item in list(value)[: abridge.length]]
    return items if _fits(value, abridge) else [*items, "..."]


def _fits(value: Any, abridge: Abridge) -> bool:
    return abridge.length is None or len(value) <= abridge.length


def _described(value: Any, kind: Any) -> str:
    item = type_name(kind.value_type)
    if isinstance(kind, definition.Array):
        return f"<array type: {item}[{kind.size}]>"
    bound = f"[{kind.maximum_size}]" if isinstance(kind, definition.BoundedSequence) else ""
    return f"<sequence type: {item}{bound}, length: {len(value)}>"


def type_name(kind: Any) -> str:
    """Return the name of the type of an array's items."""
    if isinstance(kind, definition.BasicType):
        return str(kind.typename)
    if isinstance(kind, definition.NamespacedType):
        return "/".join(kind.namespaced_name())
    return "string" if isinstance(kind, definition.AbstractString) else "wstring"


def to_yaml(message: Any, abridge: Abridge = WHOLE, flow: bool = False) -> str:
    """Return a message as YAML, in the order of its fields."""
    return dump(to_plain(message, abridge), flow)


def dump(value: Any, flow: bool = False) -> str:
    """Return a plain value as YAML, in its own order and with no line broken."""
    text: str = yaml.dump(
        value,
        Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper),
        sort_keys=False,
        allow_unicode=True,
        width=_WIDTH,
        default_flow_style=flow,
    )
    return text


def to_csv(message: Any, abridge: Abridge = WHOLE) -> str:
    """Return a message's values separated by commas."""
    return ",".join(_flat(to_plain(message, abridge)))


def _flat(value: Any) -> list[str]:
    if isinstance(value, dict):
        return [text for item in value.values() for text in _flat(item)]
    if isinstance(value, list):
        return [text for item in value for text in _flat(item)]
    return [str(value)]


def parse(text: str) -> dict[str, Any]:
    """Return what a person typed as YAML.

    Raises:
        Ros2Error: It is no dictionary in YAML.
    """
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise Ros2Error(f"The passed value is no YAML: {error}") from error
    values = {} if values is None else values
    if not isinstance(values, dict):
        raise Ros2Error("The passed value needs to be a dictionary in YAML format")
    return values


def fill(message: Any, values: dict[str, Any]) -> list[Callable[[Any], None]]:
    """Set fields of a message.

    Returns:
        What sets the stamps that were given as `now`, or `auto` for a whole header, to a time.

    Raises:
        Ros2Error: A field does not exist, or a value is of the wrong type.
    """
    stamps: list[Callable[[Any], None]] = []
    try:
        _fill(message, values, stamps)
    except (AttributeError, TypeError, ValueError, AssertionError) as error:
        raise Ros2Error(f"Failed to populate field: {error}") from error
    return stamps


def _fill(message: Any, values: Any, stamps: list[Callable[[Any], None]]) -> None:
    if not isinstance(values, dict):
        kind = type(values).__name__
        raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {kind}")
    kinds = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    for name, value in values.items():
        field = getattr(message, name)
        if not is_message(field):
            setattr(message, name, _converted(field, kinds[name], value, stamps))
        elif value == "auto" and type(field).__name__ == "Header":
            stamps.append(partial(setattr, field, "stamp"))
        elif value == "now" and type(field).__name__ == "Time":
            stamps.append(partial(setattr, message, name))
        else:
            _fill(field, value, stamps)


def _converted(field: Any, kind: Any, value: Any, stamps: list[Callable[[Any], None]]) -> Any:
    """Return a value as the type of the field that it goes to."""
    item = getattr(kind, "value_type", None)
    if isinstance(item, definition.NamespacedType):
        made = [nested_class(item)() for _ in value]
        for message, values in zip(made, value, strict=True):
            _fill(message, values, stamps)
        return made
    if isinstance(field, array.array):
        return array.array(field.typecode, value)
    if isinstance(field, np.ndarray):
        return np.array(value, dtype=field.dtype)
    if isinstance(field, bytes) and isinstance(value, int):
        return bytes([value])
    return value if type(value) is type(field) else type(field)(value)
