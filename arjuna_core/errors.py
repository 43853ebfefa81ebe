"""Exceptions: each is a mistake of the caller or of an input, never an algorithm's outcome."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path


class ArjunaError(Exception):
    """Root of every error that Arjuna raises on purpose; its message has 500 characters at most."""

    def __init__(self, message: str = "") -> None:
        super().__init__(shortened(message, 500))


class ConfigError(ArjunaError, ValueError):
    """Parameters are unknown, of the wrong type or outside their bounds: a line each."""

    def __init__(self, *problems: str) -> None:
        self.problems = tuple(shortened(problem, 500) for problem in problems)
        Exception.__init__(self, "\n".join(self.problems))


def shortened(text: str, most: int) -> str:
    """Return a text, without its middle where it has more characters than it may."""
    dots = " ... "
    tail = (most - len(dots)) // 3
    return text if len(text) <= most else text[: most - len(dots) - tail] + dots + text[-tail:]


class InputFileError(ArjunaError):
    """A file a user gave cannot be used.

    Args:
        problem: What is wrong and what is valid, one sentence.
        location: Position in the file: a line, an element, a key.

    Attributes:
        origin: What writes files of the kind, for one that is missing.
    """

    origin = ""

    def __init__(self, path: str | Path, problem: str, location: str | None = None) -> None:
        self.path = Path(path)
        # What is quoted of a broken file may hold lines, and be of any length.
        self.location = location and shortened(" ".join(location.split()), 60)
        where = f"{shortened(' '.join(str(path).split()), 200)}: "
        where += f"{self.location}: " if self.location else ""
        self.problem = shortened(" ".join(problem.split()), 500 - len(where))
        super().__init__(where + self.problem)


class MapError(InputFileError):
    """A map's YAML or image is missing, broken or inconsistent."""

    origin = "; 'save-map' writes maps"


class RobotError(InputFileError):
    """A robot description is missing, broken or cannot be simulated."""


class WorldError(InputFileError):
    """A world file is missing, broken or cannot be simulated."""


_LOOK_ALIKES = str.maketrans({"i": "1", "l": "1", "|": "1", "o": "0", "s": "5", "z": "2"})


def interrupted(error: BaseException | None) -> bool:
    """Return whether Ctrl-C is an error's root: C extensions that import, and kernels, drop it."""
    return error is not None and (
        isinstance(error, KeyboardInterrupt) or interrupted(error.__cause__ or error.__context__)
    )


def nearest(name: str, valid: Iterable[str]) -> str:
    """Return a suggestion for an unknown name.

    Returns:
        `did you mean 'x'?` where a name is close, else the sorted list of valid names.
    """
    names = sorted(valid)
    # Names are close that share 0.6 of their letters.
    meant = _closest(name, names, 0.6)
    return f"did you mean '{meant}'?" if meant else f"valid: {', '.join(names) or 'none'}"


def closest(name: str, valid: Iterable[str]) -> str:
    """Return `; the nearest is 'x'` for an unknown name; nothing where none is near.

    Far is a name with a third as many mistakes as letters, those of what both are part of left out.
    """
    meant = _closest(name, sorted(valid), 0.0) or ""
    given, theirs = _plain(name).split("."), _plain(meant).split(".")
    while given[1:] and theirs[1:] and given[0] == theirs[0]:
        del given[0], theirs[0]
    own, other = ".".join(given), ".".join(theirs)
    is_near = meant and 3 * _mistakes(own, other) <= len(own)
    return f"; the nearest is '{meant}'" if is_near else ""


def _closest(name: str, names: list[str], alike: float) -> str | None:
    """Return the one of the names that share this part of their letters with the fewest mistakes.

    Upper case, `-` or a space for `_`, and letters that look alike (`l` and `1`) are hardly one.
    """
    given, plain = _plain(name), {each: _plain(each) for each in names}
    # The eight names that share most letters are compared letter by letter.
    shapes = difflib.get_close_matches(given, dict.fromkeys(plain.values()), 8, alike)
    close = [each for each in names if plain[each] in shapes]
    mistakes = {each: _mistakes(given, plain[each]) for each in close}
    fewest = [each for each in close if mistakes[each] == min(mistakes.values())]
    return min(fewest, key=lambda each: edits(name, each), default=None)


def _plain(name: str) -> str:
    """Return a name with one letter for those that are one to a hasty writer."""
    return name.lower().replace("-", "_").replace(" ", "_")


def _mistakes(name: str, other: str) -> int:
    """Return how many letters of two names differ, those that look alike left out.

    A name cut short is one of two mistakes, however long the rest is.
    """
    found = edits(name.translate(_LOOK_ALIKES), other.translate(_LOOK_ALIKES))
    return min(found, 2) if other.startswith(name) else found


@lru_cache(maxsize=4096)
def edits(name: str, other: str) -> int:
    """Return how many letters to insert, leave out, replace or swap make one name the other.

    Source: Damerau, "A technique for computer detection and correction of spelling errors",
    CACM 1964, in its form of optimal string alignment.
    """
    before = last = list(range(len(other) + 1))
    for i, letter in enumerate(name, 1):
        row = [i]
        for j, theirs in enumerate(other, 1):
            costs = [row[-1] + 1, last[j] + 1, last[j - 1] + (letter != theirs)]
            if i > 1 and j > 1 and letter == other[j - 2] and name[i - 2] == theirs:
                costs.append(before[j - 2] + 1)
            row.append(min(costs))
        before, last = last, row
    return last[-1]
