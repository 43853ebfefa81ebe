"""Messages as rosbridge writes them in JSON, and filled from what its clients send.

Source: rosbridge_library's `message_conversion`: bytes are in base64, numbers that JSON has not are
null, and a header without a stamp is of now.
"""

from __future__ import annotations

import array
import math
from base64 import b64decode, b64encode
from collections.abc import Callable
from typing import Any

import numpy as np
from rosidl_parser.definition import AbstractNestedType, BasicType, NamespacedType

from arjuna_core.ros.messages import interface
from bringup.ros2.values import fields_of, fill, is_message

_BYTES = ("uint8", "char")
_OF_ROS1 = {"secs": "sec", "nsecs": "nanosec"}


def to_json(value: Any) -> Any:
    """Return a message, or a field of one, as JSON has it."""
    if is_message(value):
        return {name: to_json(field) for name, field, _ in fields_of(value)}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, bytes):
        return int.from_bytes(value, "little")
    if isinstance(value, (array.array, np.ndarray)):
        return _numbers(np.asarray(value))
    return [to_json(each) for each in value] if isinstance(value, (list, tuple)) else value


def _numbers(values: Any) -> Any:
    if values.dtype == np.uint8:
        return b64encode(values.tobytes()).decode("ascii")
    listed = values.tolist()
    if values.dtype.kind != "f" or np.isfinite(values).all():
        return listed
    return [each if math.isfinite(each) else None for each in listed]


def filled(message: Any, values: Any, now: Callable[[], Any]) -> Any:
    """Return a message with the fields that a client sent.

    Args:
        now: Returns the time of headers that have none.

    Raises:
        Ros2Error: A field does not exist, or a value is of the wrong type.
    """
    for stamp in fill(message, _read(message, values)):
        stamp(now())
    return message


def _read(message: Any, values: Any) -> Any:
    """Return a message's fields as `fill` takes them."""
    if not isinstance(values, dict):
        return values
    kinds = {name: (field, kind) for name, field, kind in fields_of(message)}
    name = type(message).__name__
    if name in ("Time", "Duration"):
        values = {_OF_ROS1.get(key, key): value for key, value in values.items()}
    read = {k: _field(*kinds[k], v) if k in kinds else v for k, v in values.items()}
    return {"stamp": "now", **read} if name == "Header" else read


def _field(field: Any, kind: Any, value: Any) -> Any:
    if is_message(field):
        return _read(field, value)
    item = kind.value_type if isinstance(kind, AbstractNestedType) else None
    if isinstance(item, BasicType) and item.typename in _BYTES and isinstance(value, str):
        return list(b64decode(value))
    if isinstance(item, NamespacedType) and isinstance(value, list):
        return [_read(interface(item)(), each) for each in value]
    return value
