"""A page of the tutorial: its sections, their commands, and what each promises to show."""

from __future__ import annotations

import itertools
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text

_HEADING = re.compile(r"^## (.+)$")
_FENCE = re.compile(r"^```(\w*)$")
_CTRL_C = re.compile(r"#\s*Ctrl-C after (\d+) s")
_BY_HAND = re.compile(r"#\s*by hand")
COMMANDS, SHOWN = "sh", "text"
"""Languages of the blocks that hold commands, and what they print."""
_ANY = re.compile(r"\.{3}(?!\.)")  # so that of four the first is the number's own


@dataclass(frozen=True)
class Command:
    """One command.

    Attributes:
        words: Its words, without what is said to the reader.
        stays: Whether it runs on beside those that follow (`&`).
        seconds: After how long it is ended with Ctrl-C [s]; None for when it ends by itself.
        by_hand: Whether it needs somebody at the keyboard.
    """

    text: str
    words: tuple[str, ...]
    stays: bool = False
    seconds: float | None = None
    by_hand: bool = False


@dataclass(frozen=True)
class Section:
    """One exercise.

    Attributes:
        promises: What the commands together print, a line each, in any order; `...` is anything.
    """

    title: str
    text: str
    commands: tuple[Command, ...]
    promises: tuple[str, ...]

    def missing(self, printed: str) -> list[str]:
        """Return the promises that some output does not keep."""
        return [line for line in self.promises if not _pattern(line).search(printed)]


@dataclass(frozen=True)
class Page:
    """A page: its title, and its sections that have commands."""

    title: str
    sections: tuple[Section, ...]


def load_page(path: Path) -> Page:
    """Read a page.

    Raises:
        InputFileError: It cannot be read, or no command stands in it.
    """
    lines = read_text(path).splitlines()
    title = next((line[2:] for line in lines if line.startswith("# ")), path.stem)
    try:
        sections = tuple(section for section in _sections(lines) if section.commands)
    except ValueError as error:  # as of a quote that is not closed
        raise InputFileError(path, f"holds a command that is none: {error}") from error
    if not sections:
        raise InputFileError(
            path, f"holds no command; valid: '## TITLE' and blocks of '{COMMANDS}'"
        )
    return Page(title, sections)


def _sections(lines: list[str]) -> Iterator[Section]:
    starts = [i for i, line in enumerate(lines) if _HEADING.match(line)]
    for start, end in itertools.pairwise([*starts, len(lines)]):
        yield _section(lines[start][3:], lines[start + 1 : end])


def _section(title: str, lines: list[str]) -> Section:
    text: list[str] = []
    commands: list[Command] = []
    promises: list[str] = []
    language: str | None = None
    for line in lines:
        fence = _FENCE.match(line)
        if fence:
            language = fence.group(1) if language is None else None
        elif language == COMMANDS and line.strip():
            commands.append(_command(line.strip()))
        elif language == SHOWN and line.strip():
            promises.append(line.strip())
        elif language is None and not commands:
            text.append(line)
    return Section(title, "\n".join(text).strip(), tuple(commands), tuple(promises))


def _command(line: str) -> Command:
    after = _CTRL_C.search(line)
    words = shlex.split(line, comments=True)
    stays = words[-1:] == ["&"]
    return Command(
        line,
        tuple(words[:-1] if stays else words),
        stays,
        float(after.group(1)) if after else None,
        _BY_HAND.search(line) is not None,
    )


def _pattern(promise: str) -> re.Pattern[str]:
    parts = [r"\s+".join(map(re.escape, part.split())) for part in _ANY.split(promise)]
    return re.compile(".*".join(parts))
