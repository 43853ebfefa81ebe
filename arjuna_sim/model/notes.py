"""Notes: what a file says and the simulation leaves out or does otherwise."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

_NAMED = re.compile(r"(link|model|joint|gazebo|actor) '([^']*)'(.*)", re.DOTALL)


class NoteKind(Enum):
    """The effect of something that a file says."""

    MISSING = "missing"
    """It refers to a file or package that does not exist."""
    UNSUPPORTED = "unsupported"
    """A shape or mesh is there, and of a form that is not simulated."""
    BROKEN = "broken"
    """A model, link or shape is there, and is none that can be; it is left out."""
    IGNORED = "ignored"
    """An element, attribute or argument has no effect."""
    CHANGED = "changed"
    """It is simulated, otherwise than the file says."""


@dataclass(frozen=True)
class Note:
    """One line on what was read and is not simulated as it stands.

    Attributes:
        kind: What became of it.
        text: What a person reads.
        of: `collision`, or `visual` for what is seen and not touched; "" for anything else.
    """

    kind: NoteKind
    text: str
    of: str = ""


def gathered(notes: Iterable[Note]) -> tuple[str, ...]:
    """Return the texts of notes; what they say of several of one kind is one line."""
    found: dict[tuple[str, str], list[str]] = {}
    for note in notes:
        match = _NAMED.fullmatch(note.text)
        what, name, rest = match.groups() if match else (note.text, "", "")
        found.setdefault((what, rest), []).append(name)
    return tuple(what + _names(names) + rest for (what, rest), names in found.items())


def _names(names: list[str]) -> str:
    first, rest = (names, []) if len(names) < 5 else (names[:3], names[3:])
    shown = ", ".join(f"'{name}'" for name in first)
    return f" {shown}{f' and {len(rest)} more' if rest else ''}" if names[0] else ""
