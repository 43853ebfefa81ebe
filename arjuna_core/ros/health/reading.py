"""Messages made of what stands in C's memory, at a third of what rclpy's own functions take.

Those make each part twice and more often: as a default of everything that it is within, then anew
to be filled. Here a message's memory is unpacked at once, and each part is made and filled once.
"""

from __future__ import annotations

import array
import ctypes
import operator
from collections.abc import Callable, Iterator
from struct import Struct
from typing import Any

import numpy as np
from rosidl_parser import definition

from arjuna_core.ros.health.layout import c_type_of, fields_of, interface, layout_of

_Values = Iterator[Any]
_Make = Callable[[_Values], Any]
_Places = list[tuple[int, str]]
CODES = {"boolean": "?", "octet": "c", "float": "f", "double": "d"} | {
    f"{sign}int{bits}": code.upper() if sign else code
    for sign in ("", "u")
    for bits, code in ((8, "b"), (16, "h"), (32, "i"), (64, "q"))
}
"""How `struct` and `array` call types of numbers; what is not here is left to rclpy."""
_POINTER, _SIZE = "Q", ctypes.sizeof(ctypes.c_void_p)
_TEXT = Struct("=Q16x")  # the pointer of a text, which ends with a zero


class _UnknownKindError(TypeError):
    """A field of a type that nothing here reads."""


def reader_of(cls: type[Any]) -> Callable[[int], Any] | None:
    """Return what makes a message of a type of its address; None where only rclpy can."""
    try:
        unpack, make, size = _taken_apart(cls)
    except _UnknownKindError:
        return None
    return lambda address: make(iter(unpack.unpack(ctypes.string_at(address, size))))


def _taken_apart(cls: type[Any]) -> tuple[Struct, _Make, int]:
    """Return what unpacks a message's values, what makes it of them, and its size [bytes]."""
    places: _Places = []
    make = _message(cls, 0, places)
    size = ctypes.sizeof(layout_of(cls))
    return _struct(places, size), make, size


def _struct(places: _Places, size: int) -> Struct:
    """Return what unpacks the values at some places, and skips what is between them."""
    form, at = "=", 0
    for place, code in places:
        form += f"{place - at}x{code}"
        at = place + Struct(f"={code}").size
    return Struct(f"{form}{size - at}x")


def _message(cls: type[Any], start: int, places: _Places) -> _Make:
    """Return what makes a message that begins at a place, and note where its values are."""
    layout, checked = layout_of(cls), cls()._check_fields
    new: Callable[[type[Any]], Any] = object.__new__
    fields = [
        (_slot(cls, name), _field(kind, start + getattr(layout, name).offset, places))
        for name, kind in fields_of(cls)
    ]
    put_checked = _slot(cls, "check_fields")

    def make(values: _Values) -> Any:
        message = new(cls)
        for put, part in fields:
            put(message, part(values))
        put_checked(message, checked)
        return message

    return make


def _slot(cls: type[Any], name: str) -> Callable[[Any, Any], None]:
    return operator.attrgetter(f"_{name}.__set__")(cls)  # type: ignore[no-any-return]


def _field(kind: Any, at: int, places: _Places) -> _Make:
    if isinstance(kind, definition.NamespacedType):
        return _message(interface(kind), at, places)
    if isinstance(kind, definition.UnboundedString | definition.BoundedString):
        places.append((at, _POINTER))
        return lambda values: _text(next(values))
    if isinstance(kind, definition.AbstractSequence):
        places += [(at, _POINTER), (at + _SIZE, _POINTER)]
        return _sequence(kind.value_type)
    if isinstance(kind, definition.Array):
        return _array(kind, at, places)
    places.append((at, _code(kind)))
    return next


def _code(kind: Any) -> str:
    code = CODES.get(getattr(kind, "typename", ""))
    if code is None:
        raise _UnknownKindError(str(kind))
    return code


def _text(pointer: int) -> str:
    return ctypes.string_at(pointer).decode("utf-8", "replace") if pointer else ""


def _array(kind: Any, at: int, places: _Places) -> _Make:
    """Return what makes an array of a fixed length."""
    code = _code(kind.value_type)
    if code in "?c":
        raise _UnknownKindError(str(kind))
    dtype = np.dtype(code)
    places.append((at, f"{kind.size * dtype.itemsize}s"))
    return lambda values: np.frombuffer(next(values), dtype).copy()


def _sequence(kind: Any) -> _Make:
    """Return what makes a list of what a pointer and a length tell of."""
    if isinstance(kind, definition.NamespacedType):
        unpack, make, size = _taken_apart(interface(kind))
        return lambda values: [
            make(iter(item))
            for item in unpack.iter_unpack(ctypes.string_at(next(values), next(values) * size))
        ]
    if isinstance(kind, definition.UnboundedString | definition.BoundedString):
        return lambda values: [
            _text(pointer)
            for (pointer,) in _TEXT.iter_unpack(
                ctypes.string_at(next(values), next(values) * _TEXT.size)
            )
        ]
    return _numbers(_code(kind), ctypes.sizeof(c_type_of(kind)))


def _numbers(code: str, size: int) -> _Make:
    """Return what makes a list of numbers, of a code and a size [bytes] each."""
    if code in "?c":
        one = Struct(f"={code}")
        return lambda values: [
            item for (item,) in one.iter_unpack(ctypes.string_at(next(values), next(values) * size))
        ]

    def make(values: _Values) -> Any:
        numbers = array.array(code)
        numbers.frombytes(ctypes.string_at(next(values), next(values) * size))
        return numbers

    return make
