"""What a message type is made of, taken apart once so that each message is checked fast."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

TIME = "builtin_interfaces/Time"
DURATION = "builtin_interfaces/Duration"
QUATERNION = "geometry_msgs/Quaternion"
_SPECIAL = (TIME, DURATION, QUATERNION)
_WITHIN = "within "
# fields that may hold what is no number: REP 117, and unmeasured parts of an IMU's message
_FREE = {
    "LaserScan": ("ranges", "intensities"),
    "Imu": ("orientation",),
    "Range": ("range",),
}


@dataclass(frozen=True)
class Part:
    """Fields of one kind, wherever they stand in a message.

    Attributes:
        kind: Their type, of ROS.
        paths: Their names, dotted.
        values: Returns all their values.
    """

    kind: str
    paths: tuple[str, ...]
    values: Callable[[Any], tuple[Any, ...]] = field(repr=False)


@dataclass(frozen=True)
class Structure:
    """The parts of a message type.

    Attributes:
        floats: Numbers that must be finite.
        texts: Strings.
        specials: Times, durations and rotations, by kind.
        sequences: Fields of many items, each kind by itself.
        ruled: The message itself and messages within whose types have a rule, by name.
    """

    floats: Part
    texts: Part
    specials: tuple[Part, ...]
    sequences: tuple[Part, ...]
    ruled: tuple[Part, ...]


def structure_of(message: Any, ruled: Collection[str]) -> Structure:
    """Take a type apart.

    Args:
        message: Any message of the type.
        ruled: The names of the types that have a rule, without their packages.
    """
    found: dict[str, list[str]] = {}
    _walk(message, "", found)
    own = "_" if hasattr(message, "_check_fields") else ""  # rclpy's, behind properties
    within = {kind: found.pop(kind) for kind in list(found) if kind.startswith(_WITHIN)}
    numbers = found.pop("double", []) + found.pop("float", [])
    texts = found.pop("string", [])
    special = tuple(_part(kind, found[kind], own) for kind in _SPECIAL if kind in found)
    many = tuple(_part(kind, found[kind], own) for kind in found if kind not in _SPECIAL)
    rules = tuple(
        _part(kind.removeprefix(_WITHIN), paths, own)
        for kind, paths in within.items()
        if kind.removeprefix(_WITHIN) in ruled
    )
    floats, strings = _part("double", numbers, own), _part("string", texts, own)
    return Structure(floats, strings, special, many, rules)


def _part(kind: str, paths: list[str], own: str) -> Part:
    """Return the fields of some paths, whose values stand behind names with a prefix."""
    if not paths:
        return Part(kind, (), lambda message: ())
    if paths == [""]:
        return Part(kind, ("",), lambda message: (message,))
    get = attrgetter(*(".".join(own + name for name in path.split(".")) for path in paths))
    if len(paths) > 1:
        return Part(kind, tuple(paths), get)
    return Part(kind, tuple(paths), lambda message: (get(message),))


def _walk(message: Any, prefix: str, found: dict[str, list[str]]) -> None:
    found.setdefault(_WITHIN + type(message).__name__, []).append(prefix.rstrip("."))
    free = _FREE.get(type(message).__name__, ())
    for name, kind in message.get_fields_and_field_types().items():
        path = prefix + name
        if name in free:
            continue
        if "[" in kind or kind.startswith("sequence<"):
            item = kind.split("[")[0].removeprefix("sequence<").split(",")[0].rstrip(">")
            found.setdefault(f"{item}[]", []).append(path)
        elif kind in _SPECIAL:
            found.setdefault(kind, []).append(path)
        elif "/" in kind:
            _walk(getattr(message, name), f"{path}.", found)
        elif kind in ("double", "float"):
            found.setdefault(kind, []).append(path)
        elif kind.startswith(("string", "wstring")):
            found.setdefault("string", []).append(path)
