"""A lesson's page, and a run of its commands as its reader would, which leaves none running."""

from __future__ import annotations

import itertools
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.errors import ArjunaError, InputFileError
from arjuna_core.files.input_file import read_text

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
        starts = [i for i, line in enumerate(lines) if line.startswith("## ")]
        found = (
            _section(lines[start][3:], lines[start + 1 : end])
            for start, end in itertools.pairwise([*starts, len(lines)])
        )
        sections = tuple(section for section in found if section.commands)
    except ValueError as error:  # as of a quote that is not closed
        raise InputFileError(path, f"holds a command that is none: {error}") from error
    if not sections:
        raise InputFileError(
            path, f"holds no command; valid: '## TITLE' and blocks of '{COMMANDS}'"
        )
    return Page(title, sections)


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


_STACKS = [("-m", "bringup", name) for name in ("sim", "slam", "nav", "robot")]
_STACK = " nodes active after "  # what `sim`, `slam` and `nav` say last


@dataclass(frozen=True)
class Times:
    """Time-outs of a lesson's command [s].

    Attributes:
        start: Until it is up.
        first_word: Before the time counts for which to watch.
        end: After Ctrl-C.
        whole: Until it ends by itself.
        look: From one look at its output to the next.
    """

    start: float = 90.0
    first_word: float = 20.0
    end: float = 20.0
    whole: float = 900.0
    look: float = 0.1


TIMES = Times()


class LessonError(ArjunaError):
    """A command did not do what its page says."""


class Running:
    """A command's process; its output goes to a file, so that it waits for no reader.

    `show` takes each piece of it, of one that stays until it is up; `printed` is all so far.
    """

    def __init__(
        self, command: Command, folder: Path, show: Callable[[str], None], times: Times = TIMES
    ) -> None:
        self._command, self._show, self._times = command, show, times
        self.printed = ""
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the process
        kept = None if command.by_hand else self._output
        self._process = subprocess.Popen(  # noqa: S603 - python and ros2 only, of our pages
            program(command.words),
            cwd=folder,
            stdin=None if command.by_hand else subprocess.DEVNULL,
            stdout=kept,
            stderr=kept,
        )

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *ended: object) -> None:
        """End it as Ctrl-C does, or by force where it does not mind."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._read(self._times.end)
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._take()
        self._output.close()

    def wait_until_up(self) -> None:
        """Wait until a stack has all its nodes, or another program says its first word.

        Raises:
            LessonError: It ends instead, or is not up in time.
        """
        is_stack = self._command.words[1:4] in _STACKS
        is_up = (lambda: _STACK in self.printed) if is_stack else (lambda: bool(self.printed))
        if not self._read(self._times.start, is_up):
            raise LessonError(f"'{self._command.text}' is not up:\n{self.printed}")
        self._show = lambda text: None

    def run(self) -> int:
        """Wait for its end, or end it after the time that the page gives; return its exit code.

        Raises:
            LessonError: It does not end in time.
        """
        if self._command.by_hand:
            return self._process.wait()
        if self._command.seconds is not None:
            self._read(self._times.first_word, lambda: bool(self.printed))
            self._read(self._command.seconds)
            self._process.send_signal(signal.SIGINT)
            self._read(self._times.end)
            return 0
        self._read(self._times.whole)
        if self._process.poll() is None:
            raise LessonError(f"'{self._command.text}' did not end in {self._times.whole:.0f} s")
        return self._process.returncode

    def _read(self, timeout: float, enough: Callable[[], bool] = lambda: False) -> bool:
        deadline = time.monotonic() + timeout
        while not enough() and self._process.poll() is None and time.monotonic() < deadline:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(self._times.look)
            self._take()
        return enough()

    def _take(self) -> None:
        size = os.fstat(self._output.fileno()).st_size
        start = len(self.printed.encode())
        new = os.pread(self._output.fileno(), size - start, start).decode("utf-8", "ignore")
        self.printed += new
        if new:
            self._show(new)


def program(words: tuple[str, ...]) -> list[str]:
    """Return what to start for a command's words.

    Raises:
        LessonError: Its program is not one that lessons use.
    """
    if words[:1] == ("python",):
        return [sys.executable, *words[1:]]
    if words[:1] == ("ros2",):
        return [sys.executable, "-m", "bringup.ros2.main", *words[1:]]
    raise LessonError(f"'{' '.join(words)}' is not run; valid: python ..., ros2 ...")


def run_section(
    section: Section, folder: Path, show: Callable[[str], None], *, attended: bool
) -> list[str]:
    """Run a section's commands in order, those that stay beside the others.

    Raises:
        LessonError: A command does not come up, or does not end.
    """
    problems: list[str] = []
    every: list[Running] = []
    with ExitStack() as staying:
        for command in section.commands:
            if command.by_hand and not attended:
                continue
            show(f"\n$ {command.text}\n")
            if command.stays:
                every.append(staying.enter_context(Running(command, folder, show)))
                every[-1].wait_until_up()
                continue
            with Running(command, folder, show) as running:
                every.append(running)
                if running.run() != 0:
                    problems.append(f"'{command.text}' failed")
    printed = "\n".join(running.printed for running in every)
    return problems + [f"not printed: {line}" for line in section.missing(printed)]
