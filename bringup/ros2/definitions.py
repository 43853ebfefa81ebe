"""Definitions of interfaces as `ros2 interface show` prints them: nested types indented."""

from __future__ import annotations

import re

from bringup.ros2.types import definition_file

# Code and comment of a line; a # inside quotes starts no comment.
_LINE = re.compile(r"""(?P<code>(?:[^#"']|"[^"]*"|'[^']*')*)(?P<comment>\#.*)?""")
_TYPE = re.compile(r"(?P<name>[A-Z]\w*|\w+/(?:msg/)?\w+)(?:\[[^]]*\])?\s+\w")


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
        code = _code(line)
        if comments:
            lines.append(line.rstrip())
        elif code:
            lines.append(code)
        nested = nested_type(code, package)
        if nested is not None:
            inner = flattened(nested, nested_comments, nested_comments)
            lines += [f"\t{text}" if text else "" for text in inner]
    return lines


def _code(line: str) -> str:
    match = _LINE.match(line)
    return match["code"].strip() if match is not None else line.strip()


def nested_type(code: str, package: str) -> str | None:
    """Return `package/msg/Name` of the type of a field, None where it is no message.

    Args:
        code: A line without its comment.
        package: The package of the line, which stands for types without one.
    """
    match = _TYPE.match(code)
    if match is None:
        return None
    parts = match["name"].split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"
