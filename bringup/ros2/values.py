"""Messages as plain values, as YAML and as CSV, and filled from YAML."""

from __future__ import annotations

import array
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import yaml
from rosidl_parser import definition

from arjuna_core.ros.messages import interface
from bringup.ros2.errors import Ros2Error

_ARRAYS = (list, tuple, set, array.array, np.ndarray)


@dataclass(frozen=True)
class Abridge:
    """Limits of a printed message.

    Attributes:
        length: Where arrays, bytes and strings are cut; None for nowhere.
    """

    length: int | None = None
    no_arrays: bool = False
    no_strings: bool = False


WHOLE = Abridge()


def is_message(value: Any) -> bool:
    """Return whether a value is a message."""
    return hasattr(value, "get_fields_and_field_types")


def fields_of(message: Any) -> list[tuple[str, Any, Any]]:
    """Return name, value and type of each field."""
    pairs = zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)
    return [(name, getattr(message, name), kind) for name, kind in pairs]


def to_plain(message: Any, abridge: Abridge = WHOLE) -> dict[str, Any]:
    """Return a message as a dictionary of plain values."""
    return {name: _plain(value, kind, abridge) for name, value, kind in fields_of(message)}


def _plain(value: Any, kind: Any, abridge: Abridge) -> Any:
    if is_message(value):
        return to_plain(value, abridge)
    if isinstance(value, str):
        return _text(value, abridge)
    if isinstance(value, bytes):
        return _cut(value.decode("latin-1"), abridge)
    if isinstance(value, np.number):
        return value.item()
    if not isinstance(value, _ARRAYS):
        return value
    if abridge.no_arrays and kind is not None:
        return _described(value, kind)
    items = [_plain(item, None, abridge) for item in list(value)[: abridge.length]]
    return items if _fits(value, abridge) else [*items, "..."]


def _text(text: str, abridge: Abridge) -> str:
    return f"<string length: <{len(text)}>>" if abridge.no_strings else _cut(text, abridge)


def _cut(text: str, abridge: Abridge) -> str:
    return text if _fits(text, abridge) else text[: abridge.length] + "..."


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


def _block(dumper: Any, value: dict[str, Any]) -> yaml.MappingNode:
    """Return a dictionary's node: it is never in flow style, but in a list that is."""
    pairs = [(dumper.represent_data(k), dumper.represent_data(v)) for k, v in value.items()]
    return yaml.MappingNode("tag:yaml.org,2002:map", pairs)


class _Dumper(yaml.SafeDumper):
    """Writes as ros2cli; libyaml's dumper writes emoji and control characters otherwise."""


_Fast: Any = type("_Fast", (getattr(yaml, "CSafeDumper", yaml.SafeDumper),), {})
for _dumper in (_Dumper, _Fast):
    _dumper.add_representer(dict, _block)


def dump(value: Any, flow: bool = False) -> str:
    """Return a plain value as YAML, in its order, no line broken; `flow`: lists on one line."""

    def written(dumper: Any) -> str:
        text: str = yaml.dump(
            *(value, None, dumper), allow_unicode=True, width=2**31 - 1, default_flow_style=flow
        )
        return text

    text = written(_Fast)
    return written(_Dumper) if "\\" in text else text


def to_csv(value: Any, abridge: Abridge = WHOLE, kind: Any = None) -> str:
    """Return a message's values separated by commas, an empty array as nothing."""
    if is_message(value):
        return _joined([to_csv(item, abridge, kind) for _, item, kind in fields_of(value)])
    if isinstance(value, str):
        return _text(value, abridge)
    if isinstance(value, bytes):
        return str(value if _fits(value, abridge) else value[: abridge.length] + b"...")
    if not isinstance(value, _ARRAYS):
        return str(value)
    if abridge.no_arrays and kind is not None:
        return _described(value, kind)
    items = [to_csv(item, abridge) for item in list(value)[: abridge.length]]
    return _joined(items if _fits(value, abridge) else [*items, "..."])


def _joined(texts: list[str]) -> str:
    """Join texts by commas; as in ros2cli, those at the start that are empty get none."""
    line = ""
    for text in texts:
        line = f"{line},{text}" if line else text
    return line


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
    made = [interface(item)() for _ in plain]
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
