"""Messages of so many parts that rclpy would take seconds to read them: their lists stay shut.

rclpy makes a Python object of every part of a message before anybody can look at it: 1.6 s for a
path of 1e5 poses, of a request or a goal as of a topic. What makes them is a C function of the
message's type, found by rclpy in an attribute of the type's class. Here another one stands before
it, which counts the parts in C's memory, where a list is a pointer and a length, and shows the
lists as empty where they are too many.
"""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from rosidl_parser import definition

MOST_PARTS = 100_000
"""Objects that are made of one message: a path of 15 000 poses takes 0.3 s."""
_CALLS = {"Parameter": 100}
"""What counts as many parts, for each is a call of a node."""
_ARRAY = 2
"""Parts that an array of a fixed length counts as, by the time that NumPy takes."""
_Convert = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p)
_BASIC: dict[str, Any] = {
    "boolean": ctypes.c_bool,
    "octet": ctypes.c_uint8,
    "char": ctypes.c_uint8,
    "wchar": ctypes.c_uint16,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "long double": ctypes.c_longdouble,
    **{f"int{bits}": getattr(ctypes, f"c_int{bits}") for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": getattr(ctypes, f"c_uint{bits}") for bits in (8, 16, 32, 64)},
}
_BOUND: dict[type[Any], Any] = {}
_RAISED: list[BaseException] = []


class _Sequence(ctypes.Structure):
    """A list or a text of a message in C."""

    _fields_ = (
        ("data", ctypes.c_void_p),
        ("size", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
    )


@dataclass(frozen=True)
class _List:
    """A field that is a list of messages or texts.

    Attributes:
        path: Its name, after those of the fields it is within.
        offset: Where it stands in the message's memory [bytes].
        parts: The objects that each item becomes, without those of lists within.
        stride: From one item to the next [bytes].
        within: The lists of each item.
    """

    path: tuple[str, ...]
    offset: int
    parts: int
    stride: int
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


def interface(kind: Any) -> Any:
    """Return the class of a field's type; an action's parts are classes of the action."""
    module = importlib.import_module(".".join(kind.namespaces))
    whole, _, part = kind.name.rpartition("_")
    is_part = part in ("Goal", "Result", "Feedback") and hasattr(module, whole)
    return getattr(getattr(module, whole), part) if is_part else getattr(module, kind.name)


def _stand_before(cls: type[Any]) -> Any:
    """Put a counting function before the one that reads a type; return it, for it must stay."""
    meta: Any = type(cls)
    if meta._TYPE_SUPPORT is None:
        meta.__import_type_support__()
    lists = tuple(_lists(cls))
    if not lists:
        return None
    pointer, capsule = ctypes.pythonapi.PyCapsule_GetPointer, ctypes.pythonapi.PyCapsule_New
    pointer.argtypes, pointer.restype = (ctypes.py_object, ctypes.c_char_p), ctypes.c_void_p
    capsule.argtypes, capsule.restype = (ctypes.c_void_p,) * 3, ctypes.py_object
    read: Callable[[int], Any] = _Convert(pointer(meta._CONVERT_TO_PY, None))

    def convert(address: int) -> Any:
        try:
            return read(address) if _parts(address, lists) <= MOST_PARTS else _shut(address)
        except BaseException as error:  # noqa: BLE001 - C would go on with no message at all
            _RAISED.append(error)
            return cls()

    def _shut(address: int) -> Any:
        fields = [_Sequence.from_address(address + each.offset) for each in lists]
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
        sequence = _Sequence.from_address(address + each.offset)
        total += int(sequence.size) * each.parts
        for number in range(sequence.size if each.within else 0):
            if total > MOST_PARTS:
                return total
            total += _parts(sequence.data + number * each.stride, each.within)
    return total


def _lists(cls: type[Any], start: int = 0, path: tuple[str, ...] = ()) -> Iterable[_List]:
    layout = _layout(cls)
    for name, kind in _fields(cls):
        offset = start + getattr(layout, name).offset
        if isinstance(kind, definition.NamespacedType):
            yield from _lists(interface(kind), offset, (*path, name))
        elif isinstance(kind, definition.AbstractSequence):
            item = kind.value_type
            size = ctypes.sizeof(_c_type(item))
            if isinstance(item, definition.NamespacedType):
                made = interface(item)
                yield _List((*path, name), offset, _objects(made), size, tuple(_lists(made)))
            elif isinstance(item, definition.AbstractGenericString):
                yield _List((*path, name), offset, 1, size, ())


def _objects(cls: type[Any]) -> int:
    kinds = [kind for _, kind in _fields(cls)]
    within = (interface(kind) for kind in kinds if isinstance(kind, definition.NamespacedType))
    arrays = sum(isinstance(kind, definition.Array) for kind in kinds)
    return _CALLS.get(cls.__name__, 1) + _ARRAY * arrays + sum(map(_objects, within))


def _fields(cls: type[Any]) -> Iterable[tuple[str, Any]]:
    return zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True)


def _layout(cls: type[Any]) -> type[ctypes.Structure]:
    """Return where a message's fields stand in C, whose structures no message leaves empty."""
    fields = [(name, _c_type(kind)) for name, kind in _fields(cls)]
    nothing = [("structure_needs_at_least_one_member", ctypes.c_uint8)]
    return type("Layout", (ctypes.Structure,), {"_fields_": fields or nothing})


def _c_type(kind: Any) -> Any:
    if isinstance(kind, definition.BasicType):
        return _BASIC[kind.typename]
    if isinstance(kind, definition.NamespacedType):
        return _layout(interface(kind))
    if isinstance(kind, definition.Array):
        return _c_type(kind.value_type) * kind.size
    return _Sequence
