"""Messages of so many parts that rclpy would take seconds to read them: their lists stay shut.

rclpy makes a Python object of every part of a message before anybody can look at it: 1.6 s for a
path of 1e5 poses, of a request or a goal as of a topic. What makes them is a C function of the
message's type, found by rclpy in an attribute of the type's class. Here another one stands in its
place, which counts the parts in C's memory, where a list is a pointer and a length, and shows the
lists as empty where they are too many; else it reads them, where it can, by a faster way.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rosidl_parser import definition

from arjuna_core.ros.health.layout import Sequence, c_type_of, fields_of, interface, layout_of
from arjuna_core.ros.health.reading import reader_of

MOST_PARTS = 100_000
"""Objects that are made of one message: a path of 15 000 poses takes 0.3 s."""
_CALLS = {"Parameter": 100, "ListParameters_Request": 100}
"""What counts as many parts, for each, or each text within, is a call of a node."""
_ARRAY = 2
"""Parts that an array of a fixed length counts as, by the time that NumPy takes."""
_COPIED = 4096
"""Bytes of text that count as a part."""
_SHORT = 16
"""Texts of as few items are not looked at."""
_Convert = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p)
_BOUND: dict[type[Any], Any] = {}
_RAISED: list[BaseException] = []


@dataclass(frozen=True)
class _List:
    """A field that is a list of messages or texts.

    Attributes:
        path: Its name, after those of the fields it is within.
        offset: Where it stands in the message's memory [bytes].
        parts: The objects that each item becomes, without those of lists within.
        stride: From one item to the next [bytes].
        texts: Where the lengths of each item's texts stand [bytes].
        within: The lists of each item.
    """

    path: tuple[str, ...]
    offset: int
    parts: int
    stride: int
    texts: tuple[int, ...]
    within: tuple[_List, ...]


def bound(classes: Iterable[type[Any]]) -> None:
    """Bound the work of reading messages of some types in this process, once and for all."""
    for cls in classes:
        if cls not in _BOUND:
            _BOUND[cls] = _stand_before(cls)


def raise_what_was_raised() -> None:
    """Raise what was raised while a message was read: nothing can be raised through C."""
    if _RAISED:
        raise _RAISED.pop()


def _stand_before(cls: type[Any]) -> Any:
    """Put a counting function before the one that reads a type; return it, for it must stay."""
    meta: Any = type(cls)
    if meta._TYPE_SUPPORT is None:
        meta.__import_type_support__()
    lists, reader = tuple(_lists(cls)), reader_of(cls)
    if not lists and reader is None:
        return None
    pointer, capsule = ctypes.pythonapi.PyCapsule_GetPointer, ctypes.pythonapi.PyCapsule_New
    pointer.argtypes, pointer.restype = (ctypes.py_object, ctypes.c_char_p), ctypes.c_void_p
    capsule.argtypes, capsule.restype = (ctypes.c_void_p,) * 3, ctypes.py_object
    read: Callable[[int], Any] = reader or _Convert(pointer(meta._CONVERT_TO_PY, None))

    def convert(address: int) -> Any:
        try:
            return read(address) if _parts(address, lists) <= MOST_PARTS else _shut(address)
        except BaseException as error:  # noqa: BLE001 - C would go on with no message at all
            _RAISED.append(error)
            return cls()

    def _shut(address: int) -> Any:
        fields = [Sequence.from_address(address + each.offset) for each in lists]
        sizes = [field.size for field in fields]
        for field in fields:
            field.size = 0
        try:
            message = read(address)
        finally:
            for field, size in zip(fields, sizes, strict=True):
                field.size = size
        size, longest = max(zip(sizes, lists, strict=True), key=lambda pair: pair[0])
        _mark(message, longest.path, f"{'.'.join(longest.path)} has {size} items, too many to read")
        return message

    callback = _Convert(convert)
    meta._CONVERT_TO_PY = capsule(ctypes.cast(callback, ctypes.c_void_p), None, None)
    return callback


def _mark(message: Any, path: tuple[str, ...], refusal: str) -> None:
    """Let a message, and those within up to the list, say why they cannot be used."""
    for name in path:
        kind: Any = type(message)
        namespace = {"__slots__": (), "refusal": refusal, "__module__": kind.__module__}
        message.__class__ = type(kind)(kind.__name__, (kind,), namespace)
        message = getattr(message, name)


def _parts(address: int, lists: tuple[_List, ...]) -> int:
    """Count the parts in lists; it ends where they are too many."""
    total = 0
    for each in lists:
        sequence = Sequence.from_address(address + each.offset)
        total += int(sequence.size) * each.parts
        if sequence.size > _SHORT and total <= MOST_PARTS:
            total += _copied(sequence, each)
        for number in range(sequence.size if each.within else 0):
            if total > MOST_PARTS:
                return total
            total += _parts(sequence.data + number * each.stride, each.within)
    return total


def _copied(sequence: Sequence, each: _List) -> int:
    """Return the parts that the texts of a list's items count as."""
    if not each.texts:
        return 0
    memory = ctypes.string_at(sequence.data, sequence.size * each.stride)
    words = np.frombuffer(memory, np.uintp).reshape(sequence.size, -1)
    return int(words[:, [at // words.itemsize for at in each.texts]].sum()) // _COPIED


def _lists(cls: type[Any], start: int = 0, path: tuple[str, ...] = ()) -> Iterable[_List]:
    layout = layout_of(cls)
    for name, kind in fields_of(cls):
        offset = start + getattr(layout, name).offset
        if isinstance(kind, definition.NamespacedType):
            yield from _lists(interface(kind), offset, (*path, name))
        elif isinstance(kind, definition.AbstractSequence):
            item, here = kind.value_type, ((*path, name), offset)
            size = ctypes.sizeof(c_type_of(item))
            if isinstance(item, definition.NamespacedType):
                made = interface(item)
                texts, within = tuple(_texts(made)), tuple(_lists(made))
                yield _List(*here, _objects(made), size, texts, within)
            elif isinstance(item, definition.AbstractGenericString):
                yield _List(*here, _CALLS.get(cls.__name__, 1), size, (Sequence.size.offset,), ())


def _texts(cls: type[Any], start: int = 0) -> Iterable[int]:
    """Return where the lengths of a message's texts stand, but for those of lists [bytes]."""
    layout = layout_of(cls)
    for name, kind in fields_of(cls):
        offset = start + getattr(layout, name).offset
        if isinstance(kind, definition.NamespacedType):
            yield from _texts(interface(kind), offset)
        elif isinstance(kind, definition.AbstractGenericString):
            yield offset + Sequence.size.offset


def _objects(cls: type[Any]) -> int:
    kinds = [kind for _, kind in fields_of(cls)]
    within = (interface(kind) for kind in kinds if isinstance(kind, definition.NamespacedType))
    arrays = sum(isinstance(kind, definition.Array) for kind in kinds)
    return _CALLS.get(cls.__name__, 1) + _ARRAY * arrays + sum(map(_objects, within))
