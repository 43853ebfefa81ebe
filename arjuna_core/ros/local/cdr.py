"""A message's bytes on the wire: CDR, version 1, little endian, with zeros where nothing is.

Source: OMG, DDS Interoperability Wire Protocol 2.2 (RTPS), section 10.2. What `rclpy.serialization`
returns has what the memory held before in its gaps, and so is not the same in every run.
"""

from __future__ import annotations

import array
from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from struct import Struct
from typing import Any

import numpy as np
from rosidl_parser import definition

from arjuna_core.ros.messages import compiled, fields_of, interface

CODES = {"boolean": "?", "octet": "c", "float": "f", "double": "d"} | {
    f"{sign}int{bits}": code.upper() if sign else code
    for sign in ("", "u")
    for bits, code in ((8, "b"), (16, "h"), (32, "i"), (64, "q"))
}
HEADER = b"\x00\x01\x00\x00"
_GAPS = tuple(b"\x00" * size for size in range(8))
_length = Struct("<I").pack
_Write = Callable[[bytearray, Any], None]


def to_cdr(message: Any) -> bytes:
    """Return a message's bytes, as a subscription gets them through the middleware."""
    out = bytearray(HEADER)
    kind: Any = type(message)
    _writer(kind)(out, message)
    return bytes(out)


@cache
def _writer(cls: Any) -> _Write:
    """Return what writes messages of a type, compiled: numbers side by side are packed at once."""
    known: dict[str, Any] = {"gaps": _GAPS, "length": _length, "text": _text}
    lines, run = ["def write(out, m):"], list[tuple[str, str]]()
    for path, kind in flat(cls, ""):
        if isinstance(kind, definition.BasicType):
            run.append((f"m.{path}", CODES[kind.typename]))
            continue
        lines += [*_numbers(run, known), *_field(f"m.{path}", kind, known)]
        run = []
    return compiled("write", lines + _numbers(run, known), known)  # type: ignore[no-any-return]


def flat(cls: type[Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield the paths and the types of all fields that are no messages; no type: an empty one's."""
    if not fields_of(cls):
        yield prefix, None
    for name, kind in fields_of(cls):
        if isinstance(kind, definition.NamespacedType):
            yield from flat(interface(kind), f"{prefix}_{name}.")
        else:
            yield f"{prefix}_{name}", kind


def _numbers(run: list[tuple[str, str]], known: dict[str, Any]) -> list[str]:
    """Return the line that writes numbers side by side, wherever the first may begin."""
    if not run:
        return []
    name = f"forms_{len(known)}"
    known[name] = [form([code for _, code in run], start).pack for start in range(8)]
    values = ", ".join(path for path, _ in run)
    return [f"    out += {name}[(len(out) - 4) & 7]({values})"]


def form(codes: list[str], start: int) -> Struct:
    """Return the struct that packs numbers from an offset on, with the gaps between them."""
    text, at = "<", start
    for code in codes:
        size = Struct(f"<{code}").size
        text += f"{-at % size}x{code}"
        at += -at % size + size
    return Struct(text)


def _field(path: str, kind: Any, known: dict[str, Any]) -> list[str]:
    """Return the lines that write a text, an array, a list, or what stands for no fields."""
    if kind is None:
        return ["    out.append(0)"]
    if isinstance(kind, definition.AbstractGenericString):
        return [f"    text(out, {path})"]
    count = "    out += gaps[-len(out) & 3] + length(len(items))"
    counted = [] if isinstance(kind, definition.Array) else [count]
    name = f"write_{len(known)}"
    known[name] = _items(kind.value_type)
    return [f"    items = {path}", *counted, "    if len(items):", f"        {name}(out, items)"]


def _items(item: Any) -> _Write:
    """Return what writes the items of a list, of which there are some."""
    if isinstance(item, definition.BasicType):
        return _array(CODES[item.typename])
    is_text = isinstance(item, definition.AbstractGenericString)
    write = _text if is_text else _writer(interface(item))

    def write_items(out: bytearray, items: Any) -> None:
        for each in items:
            write(out, each)

    return write_items


def _text(out: bytearray, text: str) -> None:
    out += _GAPS[-len(out) & 3]
    out += _encoded(text)


@lru_cache(maxsize=256)  # names of frames and joints come again and again
def _encoded(text: str) -> bytes:
    data = text.encode()
    return _length(len(data) + 1) + data + _GAPS[1]


def _array(code: str) -> _Write:
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
