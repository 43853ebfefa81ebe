"""Exceptions: each is a mistake of the caller or of an input, never an algorithm's outcome."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path


class ArjunaError(Exception):
    """Root of every error that Arjuna raises on purpose."""


class ConfigError(ArjunaError, ValueError):
    """Parameters are unknown, of the wrong type or outside their bounds.

    Args:
        problems: What is wrong, a sentence each.
    """

    def __init__(self, *problems: str) -> None:
        self.problems = problems
        super().__init__("\n".join(problems))


class InputFileError(ArjunaError):
    """A file a user gave cannot be used.

    Args:
        path: The file.
        problem: What is wrong and what is valid, one sentence.
        place: Where in the file: a line, an element, a key.
    """

    def __init__(self, path: str | Path, problem: str, place: str | None = None) -> None:
        self.path = Path(path)
        problem = " ".join(problem.split())  # what is quoted of a broken file may hold lines
        self.problem = problem
        self.place = place
        super().__init__(f"{path}: {place}: {problem}" if place else f"{path}: {problem}")


class MapError(InputFileError):
    """A map's YAML or image is missing, broken or inconsistent."""


class RobotError(InputFileError):
    """A robot description is missing, broken or cannot be simulated."""


class WorldError(InputFileError):
    """A world file is missing, broken or cannot be simulated."""


def nearest(name: str, valid: Iterable[str]) -> str:
    """Phrase a suggestion for an unknown name.

    Args:
        name: What was given.
        valid: The names that exist.

    Returns:
        `did you mean 'x'?` where a name is close, else the sorted list of valid names.
    """
    names = sorted(valid)
    close = difflib.get_close_matches(name, names, n=1)
    return f"did you mean '{close[0]}'?" if close else f"valid: {', '.join(names) or 'none'}"


def closest(name: str, valid: Iterable[str]) -> str:
    """Return `; the nearest is 'x'` for an unknown name; nothing where there is no valid one."""
    close = difflib.get_close_matches(name, sorted(valid), n=1, cutoff=0.0)
    return f"; the nearest is '{close[0]}'" if close else ""
