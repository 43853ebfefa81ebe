"""Notes: what a file says and the simulation leaves out or does otherwise."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


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
