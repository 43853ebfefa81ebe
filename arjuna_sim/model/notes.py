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
    UNDRAWN = "undrawn"
    """A mesh or picture that is seen, and not touched, is missing or cannot be drawn."""
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
        of: The tag of the shape that it is of; "" of anything else.
    """

    kind: NoteKind
    text: str
    of: str = ""
