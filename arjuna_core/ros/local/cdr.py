"""A message's bytes on the wire: CDR, version 1, little endian, with zeros where nothing is.

Source: OMG, DDS Interoperability Wire Protocol 2.2 (RTPS), section 10.2. What `rclpy.serialization`
returns has what the memory held before in its gaps, and so is not the same in every run.
"""

from __future__ import annotations

import array
from collections.abc import Callable, Iterator
from functools import cache
from operator import attrgetter
from struct import Struct
from typing import Any

import numpy as np
from rosidl_parser import definition

from arjuna_core.ros.messages import fields_of, interface

CODES = {"boolean": "?", "octet": "c", "float": "f", "double": "d"} | {
    f"{sign}int{bits}": code.upper() if sign else code
    for sign in ("", "u")
    for bits, code in ((8, "b"), (16, "h"), (32, "i"), (64, "q"))
}
HEADER = b"\x00\x01\x00\x00"
_GAPS = tuple(b"\x00" * size for size in range(8))
_LENGTH = Struct("<I")
_Step = Callable[[bytearray, Any], None]


def to_cdr(message: Any) -> bytes:
    """Return a message's bytes, as a subscription gets them through the middleware."""
    out = bytearray(HEADER)
    kind: Any = type(message)
    _write(out, message, _steps(kind))
    return bytes(out)


def _write(out: bytearray, message: Any, steps: tuple[_Step, ...]) -> None:
    for step in steps:
        step(out, message)


@cache
def _steps(cls: Any) -> tuple[_Step, ...]:
    """Return what writes a type: numbers that stand side by side by one step."""
    steps: list[_Step] = []
    run: list[tuple[str, str]] = []
    for path, kind in flat(cls, ""):
        if isinstance(kind, definition.BasicType):
            run.append((path, CODES[kind.typename]))
            continue
        steps += [_numbers(run)] if run else []
        steps.append(_nothing if kind is None else _field(attrgetter(path), kind))
        run = []
    return (*steps, *([_numbers(run)] if run else []))


def flat(cls: type[Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield the paths and the types of all fields that are no messages; no type: an empty one's."""
    if not fields_of(cls):
        yield prefix, None
    for name, kind in fields_of(cls):
        if isinstance(kind, definition.NamespacedType):
            yield from flat(interface(kind), f"{prefix}_{name}.")
        else:
            yield f"{prefix}_{name}", kind


def _nothing(out: bytearray, message: Any) -> None:
    """Write what stands for a message without fields."""
    out.append(0)


def _numbers(run: list[tuple[str, str]]) -> _Step:
    """Return what writes numbers side by side, wherever the first may begin."""
    forms = [form([code for _, code in run], start) for start in range(8)]
    get = attrgetter(*(path for path, _ in run))
    if len(run) == 1:
        return lambda out, message: out.extend(forms[(len(out) - 4) & 7].pack(get(message)))
    return lambda out, message: out.extend(forms[(len(out) - 4) & 7].pack(*get(message)))


def form(codes: list[str], start: int) -> Struct:
    """Return the struct that packs numbers from an offset on, with the gaps between them."""
    text, at = "<", start
    for code in codes:
        size = Struct(f"<{code}").size
        text += f"{-at % size}x{code}"
        at += -at % size + size
    return Struct(text)


def _field(get: Callable[[Any], Any], kind: Any) -> _Step:
    """Return what writes a text, an array or a list."""
    if isinstance(kind, definition.AbstractGenericString):
        return lambda out, message: _text(out, get(message))
    item, counted = kind.value_type, not isinstance(kind, definition.Array)
    write = _items(item)

    def write_list(out: bytearray, message: Any) -> None:
        items = get(message)
        if counted:
            _count(out, len(items))
        if len(items):
            write(out, items)

    return write_list


def _items(item: Any) -> _Step:
    """Return what writes the items of a list, of which there are some."""
    if isinstance(item, definition.NamespacedType):
        cls = interface(item)

        def write_messages(out: bytearray, items: Any) -> None:
            steps = _steps(cls)
            for each in items:
                _write(out, each, steps)

        return write_messages
    if isinstance(item, definition.AbstractGenericString):

        def write_texts(out: bytearray, items: Any) -> None:
            for each in items:
                _text(out, each)

        return write_texts
    return _array(CODES[item.typename])


def _array(code: str) -> _Step:
    """Return what writes numbers of one kind."""
    size = Struct(f"<{code}").size

    def write_numbers(out: bytearray, items: Any) -> None:
        out.extend(_GAPS[-(len(out) - 4) % size])
        if code == "c":
            out.extend(b"".join(items))
        elif isinstance(items, array.array | np.ndarray):
            out.extend(items.tobytes())
        else:
            out.extend(Struct(f"<{len(items)}{code}").pack(*items))

    return write_numbers


def _count(out: bytearray, count: int) -> None:
    out.extend(_GAPS[-len(out) & 3])
    out.extend(_LENGTH.pack(count))


def _text(out: bytearray, text: str) -> None:
    data = text.encode()
    _count(out, len(data) + 1)
    out.extend(data)
    out.append(0)
