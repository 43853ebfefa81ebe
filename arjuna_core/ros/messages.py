"""Messages' constructors, makers, fields and copies, by functions compiled for each type.

rclpy's constructor of a type makes each part twice, as a default and as it is given, and gets and
sets each field by a function of Python, for a check that is off unless ROS_PYTHON_CHECK_FIELDS is
set: a Twist takes 4.5 us, here 0.4 us; a field 60 ns, here 15 ns.
"""

from __future__ import annotations

import array
import importlib
from collections.abc import Callable, Iterator
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np
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

    Their users notice nothing; types whose fields are checked stay as they are.
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
    cls.__init__, cls.__getattr__ = constructor, _parts_when_read(template)
    for field, kind in fields_of(cls):
        slot = cls.__dict__[f"_{field}"]
        converted = isinstance(getattr(kind, "value_type", None), definition.BasicType)
        setter = cls.__dict__[field].fset
        setattr(cls, field, property(attrgetter(f"_{field}"), setter) if converted else slot)


def _constructor(template: Any) -> Any:
    """Return the `__init__` of a message's type; messages not given are made when they are read.

    Arrays are made at once: rclpy reads into them.
    """
    known: dict[str, Any] = {"unset": _UNSET}
    arguments, lines = ["self", "*"], ["    self._check_fields = check_fields"]
    for field, _ in fields_of(type(template)):
        default = getattr(template, f"_{field}")
        if isinstance(default, int | float | str | bytes):
            known[f"default_{field}"] = default
            arguments.append(f"{field}=default_{field}")
            lines.append(f"    self._{field} = {field}")
        else:
            arguments.append(f"{field}=unset")
            lines += [f"    if {field} is not unset:", f"        self.{field} = {field}"]
            if isinstance(default, array.array | np.ndarray):
                lines += ["    else:", f"        self._{field} = {_fresh(default, known)}"]
    head = f"def __init__({', '.join(arguments)}, check_fields=False, **unknown):"
    return compiled("__init__", [head, *lines], known)


def maker(cls: type[Any], *paths: str) -> Callable[..., Any]:
    """Return what makes messages of a type, and those within, of the values of fields, in order.

    A TransformStamped takes 0.9 us, with the constructors of its six parts 3 us. The values are
    not converted: a list of numbers is an array.

    Args:
        paths: The fields that are given, as `header.stamp.sec`; others have their defaults.

    Raises:
        ValueError: There is no such field.
    """
    names = {path: f"a{index}" for index, path in enumerate(paths)}
    known: dict[str, Any] = {"new": object.__new__}
    head = f"def made({', '.join(names.values())}):"
    lines = [*_made(cls(), "m", "", names, known), "    return m"]
    if names:
        raise ValueError(f"{cls.__name__} has no {', '.join(names)}")
    return compiled("made", [head, *lines], known)  # type: ignore[no-any-return]


def _made(
    template: Any, name: str, prefix: str, names: dict[str, str], known: dict[str, Any]
) -> list[str]:
    cls = type(template)
    known[f"type_{name}"] = cls
    lines = [f"    {name} = new(type_{name})"]
    lines.append(f"    {name}._check_fields = {template._check_fields}")
    for field, kind in fields_of(cls):
        path, part = f"{prefix}{field}", f"{name}_{field}"
        if path in names:
            value = names.pop(path)
        elif isinstance(kind, definition.NamespacedType):
            lines += _made(getattr(template, field), part, f"{path}.", names, known)
            value = part
        else:
            value = _fresh(getattr(template, field), known)
        lines.append(f"    {name}._{field} = {value}")
    return lines


def _fresh(default: Any, known: dict[str, Any]) -> str:
    """Return the expression of a field's default; each message has arrays and lists of its own."""
    name = f"default_{len(known)}"
    known[name] = default
    if isinstance(default, array.array | list):
        return f"{name}[:]"
    return f"{name}.copy()" if isinstance(default, np.ndarray) else name


def _parts_when_read(template: Any) -> Callable[[Any, str], Any]:
    """Return the `__getattr__` of a message's type, which makes messages that were not given.

    rclpy sets every message within one that it reads, so that most defaults would be unused.
    """
    makers: dict[str, Callable[[], Any]] = {}
    for field, kind in fields_of(type(template)):
        default = getattr(template, f"_{field}")
        if isinstance(kind, definition.NamespacedType):
            makers[field] = type(default)
        elif isinstance(default, list):
            makers[field] = default.copy

    def part(message: Any, name: str) -> Any:
        make = makers.get(name.removeprefix("_"))
        if make is None:
            kind = type(message).__name__
            raise AttributeError(f"'{kind}' object has no attribute '{name}'")
        value = make()
        setattr(message, f"_{name.removeprefix('_')}", value)
        return value

    return part


def compiled(name: str, lines: list[str], known: dict[str, Any]) -> Any:
    """Return the function of a name that lines of source define, of the names known."""
    code = compile("\n".join(lines), "<message>", "exec")  # of the names of fields alone
    known["__name__"] = __name__
    exec(code, known)  # noqa: S102
    return known[name]


@cache
def copier(cls: Any) -> Callable[[Any], Any]:
    """Return what copies a message of a type as CDR does, whose publisher may use it again.

    Numbers become Python's, those of 32 bits are rounded. Lists of numbers and texts are shared:
    clouds and pictures are large, and their publishers make new ones each time. A loop over the
    fields would take twice as long as the function that is compiled for them.
    """
    known: dict[str, Any] = {"new": object.__new__, "single": _single}
    lines = ["def copied(m0):", *_copied(cls, 0, known), "    return n0"]
    return compiled("copied", lines, known)  # type: ignore[no-any-return]


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
def handed_over(cls: Any, trusted: bool) -> Callable[[Any], Any] | None:
    """Return what makes the message that readers share: the same if `trusted`, else a copy.

    None for a trusted one without numbers of 32 bits: there is nothing to round.
    """
    if not trusted:
        return copier(cls)
    rounding = _rounded(cls, "m", 1)
    lines = ["def rounded(m):", *rounding, "    return m"]
    return compiled("rounded", lines, {"single": _single}) if rounding else None


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
    if isinstance(kind, definition.BasicType):
        number = _NUMBERS.get(kind.typename)
        return f"{number}({source})" if number else source
    item = getattr(kind, "value_type", None)
    if isinstance(item, definition.NamespacedType):
        each = f"each_{len(known)}"
        known[each] = copier(interface(item))
        return f"[{each}(item) for item in {source}]"
    return f"{source}.copy()" if isinstance(kind, definition.Array) else source
