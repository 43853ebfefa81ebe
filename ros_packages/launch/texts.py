"""Texts of XML and YAML launch files, with `$(NAME words ...)` in them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from arjuna_core.errors import ArjunaError, nearest
from launch import substitutions
from launch.substitution import Substitution, TextSubstitution

Text = list[Substitution]


class InvalidLaunchFileError(ArjunaError, RuntimeError):
    """A file is no launch file; the message says why."""


def parse_substitution(text: str) -> Text:
    """Return a text with `$(name words ...)` in it as substitutions."""
    found: Text = []
    at = 0
    while (start := text.find("$(", at)) >= 0:
        end = closing(text, start + 2)
        if start > at:
            found.append(TextSubstitution(text=text[at:start]))
        found.append(_substitution(text[start + 2 : end].strip()))
        at = end + 1
    if at < len(text) or not found:
        found.append(TextSubstitution(text=text[at:]))
    return found


def closing(text: str, at: int) -> int:
    """Return where the bracket is closed in which a position of a text is."""
    depth = 1
    for index in range(at, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    raise InvalidLaunchFileError(f"'{text}' lacks a ')'")


_WORD = re.compile(r"""\s*(?:'((?:[^'\\]|\\.)*)'|"((?:[^"\\]|\\.)*)"|(\S))""", re.DOTALL)


def _words(text: str) -> list[str]:
    """Return the words of a substitution: quoted ones, and those between blanks."""
    found, at = [], 0
    while (match := _WORD.match(text, at)) is not None:
        end = match.end()
        if match[3] is not None:
            end = match.start(3)
            while end < len(text) and not text[end].isspace():
                end = closing(text, end + 2) + 1 if text.startswith("$(", end) else end + 1
            found.append(text[match.start(3) : end])
        else:
            quoted = match[1] if match[1] is not None else match[2]
            found.append(re.sub(r"\\(.)", r"\1", quoted))
        at = end
    return found


def _substitution(inside: str) -> Substitution:
    name, _, rest = inside.partition(" ")
    if name not in _SUBSTITUTIONS:
        ros1 = _OF_ROS1.get(name)
        remedy = f"of ROS 1; valid: $({ros1} {rest})" if ros1 else nearest(name, _SUBSTITUTIONS)
        raise InvalidLaunchFileError(f"$({inside}) is unknown{', ' if ros1 else '; '}{remedy}")
    words = [parse_substitution(word) for word in _words(rest)]
    if name in ("eval", "command") and len(words) > 2:  # without quotes
        words = [parse_substitution(rest.strip())]
    try:
        return _SUBSTITUTIONS[name](*words)
    except TypeError as error:
        raise InvalidLaunchFileError(f"$({inside}): {error}") from error


def _ros(name: str, *words: Text) -> Substitution:
    from launch_ros import substitutions as of_ros

    found: Substitution = getattr(of_ros, name)(*words)
    return found


_OF_ROS1 = {"arg": "var", "find": "find-pkg-share", "optenv": "env"}
_SUBSTITUTIONS: dict[str, Callable[..., Substitution]] = {
    "and": lambda *words: substitutions.AndSubstitution(*words),
    "anon": lambda name: substitutions.AnonName(name),
    "command": lambda c, e="fail": substitutions.Command(c, on_stderr=e),
    "dirname": lambda: substitutions.ThisLaunchFileDir(),
    "env": lambda name, usual=None: substitutions.EnvironmentVariable(name, default_value=usual),
    "equals": lambda *words: substitutions.EqualsSubstitution(*words),
    "eval": lambda text: substitutions.PythonExpression(text),
    "exec_in_package": lambda *words: _ros("ExecutableInPackage", *words),
    "filename": lambda: substitutions.ThisLaunchFile(),
    "file_content": lambda path: substitutions.FileContent(path),
    "find_exec": lambda name: substitutions.FindExecutable(name=name),
    "find_pkg_prefix": lambda name: _ros("FindPackagePrefix", name),
    "find_pkg_share": lambda name: _ros("FindPackageShare", name),
    "if": lambda *words: substitutions.IfElseSubstitution(*words),
    "log_dir": lambda: substitutions.LaunchLogDir(),
    "not": lambda word: substitutions.NotSubstitution(word),
    "not_equals": lambda *words: substitutions.NotEqualsSubstitution(*words),
    "or": lambda *words: substitutions.OrSubstitution(*words),
    "param": lambda name: _ros("Parameter", name),
    "var": lambda name, usual=None: substitutions.LaunchConfiguration(name, default=usual),
}
_SUBSTITUTIONS |= {name.replace("_", "-"): made for name, made in _SUBSTITUTIONS.items()}


def expose_substitution(name: str) -> Callable[[type[Any]], type[Any]]:
    """Return a decorator that has `$(NAME words)` be what a class's `parse` makes of the words."""

    def exposed(kind: type[Any]) -> type[Any]:
        def made(*words: Text) -> Substitution:
            chosen, given = kind.parse(words)
            return chosen(**given)  # type: ignore[no-any-return]

        _SUBSTITUTIONS[name] = made
        return kind

    return exposed
