"""Interfaces by name: their Python classes, their packages and their definitions."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from ament_index_python import get_resource, get_resources
from ament_index_python.packages import PackageNotFoundError

from arjuna_core.ros.context import add_environment_to_ament_index, class_of
from bringup.recording.message_definitions import definition_path, nested_type
from bringup.ros2.errors import Ros2Error

_UNIT = re.compile(r"\s*\[[^,\]]+\]")
WORDS = {"msg": "message", "srv": "service", "action": "action"}


def interface_class(name: str, kind: str | None = None) -> Any:
    """Return the Python class of an interface.

    Args:
        name: `package/msg/Name`, or `package/Name` where the kind is known.
        kind: "msg", "srv" or "action"; None for any.

    Raises:
        Ros2Error: There is no such interface.
    """
    parts = name.split("/")
    if len(parts) == 2 and kind is not None:
        parts.insert(1, kind)
    is_part = kind == "msg" and "_" in parts[-1]  # an action's feedback, a service's event
    if len(parts) == 3 and parts[1] in WORDS and (is_part or kind in (None, parts[1])):
        with suppress(LookupError):
            return class_of("/".join(parts))
    if kind is None:
        raise Ros2Error(f"Could not find the interface '{name}'")
    raise Ros2Error(f"The passed {WORDS[kind]} type is invalid")


def packages() -> dict[str, list[str]]:
    """Return the interfaces of every package, `kind/Name`, all sorted."""
    add_environment_to_ament_index()
    return {name: interfaces_of(name) for name in sorted(get_resources("rosidl_interfaces"))}


def interfaces_of(package: str) -> list[str]:
    """Return the interfaces of a package, `kind/Name`, sorted.

    Raises:
        Ros2Error: There is no such package, or it has none.
    """
    add_environment_to_ament_index()
    try:
        content, _ = get_resource("rosidl_interfaces", package)
    except LookupError as error:
        raise Ros2Error(f"Unknown package '{package}'") from error
    lines = [line for line in content.splitlines() if line.endswith(".idl")]
    return sorted(line[: -len(".idl")] for line in lines)


def definition_file(name: str) -> Path:
    """Return the file that defines an interface, `package/kind/Name`.

    Raises:
        Ros2Error: There is none.
    """
    parts = name.split("/")
    if len(parts) != 3:
        raise Ros2Error(f"Invalid name '{name}'. Expected three parts separated by '/'")
    package, kind, short = parts
    try:
        path = definition_path(name, f".{kind}")
    except (PackageNotFoundError, ValueError) as error:
        raise Ros2Error(f"Unknown package '{package}'") from error
    if kind not in WORDS or not short.isidentifier() or not path.is_file():
        raise Ros2Error(f"Could not find the interface '{name}'")
    return path


def flattened(name: str, comments: bool = True, nested_comments: bool = False) -> list[str]:
    """Return a definition's lines, each nested type's below its field, one tab deeper.

    Comments and empty lines stay, those of nested types too, if asked for.

    Raises:
        Ros2Error: There is no such interface.
    """
    package = name.split("/")[0]
    lines: list[str] = []
    for line in definition_file(name).read_text(encoding="utf-8").splitlines():
        shown = line.rstrip() if comments else bare(line.rstrip())
        lines += [] if shown is None else [shown]
        nested = nested_type(line.partition("#")[0].strip(), package)
        if nested is not None:
            inner = flattened(nested, nested_comments, nested_comments)
            lines += [f"\t{text}" if text else "" for text in inner]
    return lines


def bare(line: str) -> str | None:
    """Return what ros2cli leaves of a line without comments, None for nothing.

    It finds the comments by what the parser of definitions (rosidl_adapter) notes of them: what
    stands behind a constant, is indented or says nothing but a unit stays, and a field's is cut
    a character before its first word, which leaves the `#` of most.
    """
    code, mark, comment = line.replace("\t", " ").partition("#")
    units = _UNIT.findall(comment)
    said = (comment.replace(units[0], "") if len(units) == 1 else comment).lstrip("#").lstrip()
    if not code:  # a comment, or an empty line
        return line if mark and not said else None
    if not said or not code.strip() or "=" in code.partition(" ")[2]:
        return line
    return line[: line.find(said) - 1].strip()
