"""Messages' constructors, fields and copies, by functions that are compiled for each type.

rclpy's constructor of a type makes each part twice, as a default and as it is given, and gets and
sets each field by a function of Python, for a check that is off unless ROS_PYTHON_CHECK_FIELDS is
set: a Twist takes 4.5 us, here 0.4 us; a field 60 ns, here 15 ns.
"""

from __future__ import annotations

import array
import importlib
import math
from collections.abc import Callable, Iterator
from functools import cache
from operator import attrgetter
from typing import Any

from rosidl_parser import definition

_INTEGERS = {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
_NUMBERS = {"double": "float", "float": "single", "boolean": "bool"} | dict.fromkeys(
    _INTEGERS, "int"
)
_UNSET = object()


def interface(kind: Any) -> Any:
    """Return the class of a field's type; an action's parts are classes of the action."""
    module = importlib.import_module(".".join(kind.namespaces))
    whole, _, part = kind.name.rpartition("_")
    is_part = part in ("Goal", "Result", "Feedback") and hasattr(module, whole)
    return getattr(getattr(module, whole), part) if is_part else getattr(module, kind.name)


def fields_of(cls: type[Any]) -> list[tuple[str, Any]]:
    """Return the names and the types of a message's fields."""
    return list(zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True))


def is_of_lists(cls: type[Any]) -> bool:
    """Return whether a type holds lists of messages or texts, and none of numbers."""
    lists = [kind.value_type for kind in _kinds(cls) if hasattr(kind, "value_type")]
    numbers = [isinstance(item, definition.BasicType) for item in lists]
    return bool(lists) and not any(numbers)


def _kinds(cls: type[Any]) -> Iterator[Any]:
    """Yield the types of a message's fields, those of fields of messages too; no fixed arrays."""
    for _, kind in fields_of(cls):
        if isinstance(kind, definition.NamespacedType):
            yield from _kinds(interface(kind))
        elif not isinstance(kind, definition.Array):
            yield kind


def quicken(*classes: Any) -> None:
    """Give types of messages and services, and those within, compiled constructors, plain fields.

    What their users see is the same; types whose fields are checked stay as they are.
    """
    for cls in classes:
        for part in (cls.Request, cls.Response) if hasattr(cls, "Request") else (cls,):
            _quicken(part)


@cache
def _quicken(cls: Any) -> None:
    template = cls()
    if template._check_fields:
        return
    for _, kind in fields_of(cls):
        item = getattr(kind, "value_type", kind)
        if isinstance(item, definition.NamespacedType):
            _quicken(interface(item))
    constructor = _constructor(template)
    constructor.__wrapped__ = cls.__init__
    cls.__init__ = constructor
    for field, kind in fields_of(cls):
        slot = cls.__dict__[f"_{field}"]
        converted = isinstance(getattr(kind, "value_type", None), definition.BasicType)
        setter = cls.__dict__[field].fset
        setattr(cls, field, property(attrgetter(f"_{field}"), setter) if converted else slot)


def _constructor(template: Any) -> Any:
    """Return the `__init__` of a message's type, whose defaults are what the message holds."""
    known: dict[str, Any] = {"new": object.__new__, "unset": _UNSET}
    arguments, lines = ["self", "*"], ["    self._check_fields = check_fields"]
    for field, kind in fields_of(type(template)):
        default = getattr(template, f"_{field}")
        if isinstance(kind, definition.NamespacedType):
            made = [f"        {line}" for line in _made(default, 1, known)]
            lines += [f"    if {field} is unset:", *made, f"        {field} = n1"]
            lines.append(f"    self._{field} = {field}")
        elif isinstance(getattr(kind, "value_type", None), definition.BasicType):
            lines += [
                f"    if {field} is unset:",
                f"        self._{field} = {_constant(default, known)}",
                "    else:",
                f"        self.{field} = {field}",
            ]
        elif isinstance(default, list):
            value = f"{_constant(default, known)} if {field} is unset else {field}"
            lines.append(f"    self._{field} = {value}")
        else:
            arguments.append(f"{field}={_constant(default, known)}")
            lines.append(f"    self._{field} = {field}")
            continue
        arguments.append(f"{field}=unset")
    head = f"def __init__({', '.join(arguments)}, check_fields=False, **unknown):"
    return _compiled("__init__", [head, *lines], known)


def _compiled(name: str, lines: list[str], known: dict[str, Any]) -> Any:
    code = compile("\n".join(lines), "<message>", "exec")  # of the names of fields alone
    exec(code, known)  # noqa: S102
    return known[name]


def _made(template: Any, depth: int, known: dict[str, Any]) -> list[str]:
    """Return the lines that make `n` of a depth, a message that holds what another does."""
    cls, here = type(template), f"n{depth}"
    name = f"{cls.__name__}_{len(known)}"
    known[name] = cls
    lines = [f"{here} = new({name})", f"{here}._check_fields = False"]
    for field, kind in fields_of(cls):
        default = getattr(template, f"_{field}")
        if isinstance(kind, definition.NamespacedType):
            lines += [*_made(default, depth + 1, known), f"{here}._{field} = n{depth + 1}"]
        else:
            lines.append(f"{here}._{field} = {_constant(default, known)}")
    return lines


def _constant(value: Any, known: dict[str, Any]) -> str:
    """Return the expression of a default, a copy where it can be changed."""
    if isinstance(value, int | str | bytes) or (isinstance(value, float) and math.isfinite(value)):
        return repr(value)
    name = f"default_{len(known)}"
    known[name] = value
    if isinstance(value, float):
        return name
    return f"{name}[:]" if isinstance(value, list | array.array) else f"{name}.copy()"


@cache
def copier(cls: Any) -> Callable[[Any], Any]:
    """Return what copies a message of a type as CDR does, whose publisher may use it again.

    Numbers become Python's, those of 32 bits are rounded. Lists of numbers and texts are shared:
    clouds and pictures are large, and their publishers make new ones each time. A loop over the
    fields would take twice as long as the function that is compiled for them.

    Args:
        cls: The type.
    """
    known: dict[str, Any] = {"new": object.__new__, "single": _single}
    lines = ["def copied(m0):", *_copied(cls, 0, known), "    return n0"]
    return _compiled("copied", lines, known)  # type: ignore[no-any-return]


def _copied(cls: type[Any], depth: int, known: dict[str, Any]) -> list[str]:
    """Return the lines that make `n` of a depth of `m` of that depth."""
    name = f"{cls.__name__}_{len(known)}"
    known[name] = cls
    lines = [f"    n{depth} = new({name})", f"    n{depth}._check_fields = m{depth}._check_fields"]
    for field, kind in fields_of(cls):
        source, target = f"m{depth}._{field}", f"n{depth}._{field}"
        if isinstance(kind, definition.NamespacedType):
            lines.append(f"    m{depth + 1} = {source}")
            lines += _copied(interface(kind), depth + 1, known)
            lines.append(f"    {target} = n{depth + 1}")
        else:
            lines.append(f"    {target} = {_value(source, kind, known)}")
    return lines


@cache
def handed_over(cls: Any, trusted: bool) -> Callable[[Any], Any]:
    """Return what makes of a message the one that its readers share.

    Args:
        cls: Its type.
        trusted: Whether its sender changes it no more; else it is copied.
    """
    if not trusted:
        return copier(cls)
    lines = ["def rounded(m):", *_rounded(cls, "m", 1), "    return m"]
    return _compiled("rounded", lines, {"single": _single})  # type: ignore[no-any-return]


def _single(number: float) -> float:
    return array.array("f", (number,))[0]


def _rounded(cls: type[Any], name: str, depth: int) -> list[str]:
    lines, indent = [], "    " * depth
    for field, kind in fields_of(cls):
        source, item = f"{name}._{field}", getattr(kind, "value_type", None)
        if isinstance(kind, definition.NamespacedType):
            lines += _rounded(interface(kind), source, depth)
        elif isinstance(item, definition.NamespacedType):
            within = _rounded(interface(item), f"i{depth}", depth + 1)
            lines += [f"{indent}for i{depth} in {source}:", *within] if within else []
        elif isinstance(kind, definition.BasicType) and kind.typename == "float":
            lines.append(f"{indent}{source} = single({source})")
    return lines


def _value(source: str, kind: Any, known: dict[str, Any]) -> str:
    """Return the expression that copies a field that is no message."""
    if isinstance(kind, definition.BasicType):
        number = _NUMBERS.get(kind.typename)
        return f"{number}({source})" if number else source
    item = getattr(kind, "value_type", None)
    if isinstance(item, definition.NamespacedType):
        each = f"each_{len(known)}"
        known[each] = copier(interface(item))
        return f"[{each}(item) for item in {source}]"
    return f"{source}.copy()" if isinstance(kind, definition.Array) else source
