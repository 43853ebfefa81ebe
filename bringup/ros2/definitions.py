"""Definitions of interfaces as `ros2 interface show` prints them: nested types indented."""

from __future__ import annotations

import re

from bringup.ros2.types import definition_file

_TYPE = re.compile(r"(?P<name>[A-Z]\w*|\w+/(?:msg/)?\w+)(?:\[[^]]*\])?\s+\w")
_UNIT = re.compile(r"\s*\[[^,\]]+\]")


def flattened(name: str, comments: bool = True, nested_comments: bool = False) -> list[str]:
    """Return the lines of a definition, each nested type's below its field, one tab deeper.

    Args:
        name: `package/kind/Name`.
        comments: Whether comments and empty lines stay.
        nested_comments: Whether those of nested types stay.

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


def nested_type(code: str, package: str) -> str | None:
    """Return `package/msg/Name` of the type of a field, None where it is no message.

    Args:
        code: A line without its comment.
    """
    match = _TYPE.match(code)
    if match is None:
        return None
    parts = match["name"].split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"
