"""Where the fields of a message's type stand in C's memory."""

from __future__ import annotations

import ctypes
import importlib
from typing import Any

from rosidl_parser import definition

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


class Sequence(ctypes.Structure):
    """A list or a text of a message in C."""

    _fields_ = (
        ("data", ctypes.c_void_p),
        ("size", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
    )


def interface(kind: Any) -> Any:
    """Return the class of a field's type; an action's parts are classes of the action."""
    module = importlib.import_module(".".join(kind.namespaces))
    whole, _, part = kind.name.rpartition("_")
    is_part = part in ("Goal", "Result", "Feedback") and hasattr(module, whole)
    return getattr(getattr(module, whole), part) if is_part else getattr(module, kind.name)


def fields_of(cls: type[Any]) -> list[tuple[str, Any]]:
    """Return the names and the types of a message's fields."""
    return list(zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True))


def layout_of(cls: type[Any]) -> type[ctypes.Structure]:
    """Return where a message's fields stand in C, whose structures no message leaves empty."""
    fields = [(name, c_type_of(kind)) for name, kind in fields_of(cls)]
    nothing = [("structure_needs_at_least_one_member", ctypes.c_uint8)]
    return type("Layout", (ctypes.Structure,), {"_fields_": fields or nothing})


def c_type_of(kind: Any) -> Any:
    """Return what a field of a type is in C."""
    if isinstance(kind, definition.BasicType):
        return _BASIC[kind.typename]
    if isinstance(kind, definition.NamespacedType):
        return layout_of(interface(kind))
    if isinstance(kind, definition.Array):
        return c_type_of(kind.value_type) * kind.size
    return Sequence
