"""Processes under test: their output line by line and their end, each with a deadline."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

DEADLINE = 60.0  # [s, wall]: what fails, fails late; a busy machine is slow


def wait_until(
    done: Callable[[], Any], step: Callable[[], Any], what: object, within: float = DEADLINE
) -> None:
    """Step until something is so that another thread or process brings.

    Args:
        done: Whether it is.
        step: What to do between two looks; it waits a little.
        what: How the error calls it, as it is then.
        within: How long it may take [s, wall].
    """
    deadline = time.monotonic() + within
    while not done():
        assert time.monotonic() < deadline, f"waited {within:g} s for {what}"
        step()


def given_parameters(command: Sequence[str]) -> dict[str, Any]:
    """Return the parameters that a host's command names: they are in a file, not in its words."""
    word = command[command.index("--parameters") + 1]
    assert word.startswith("@"), word
    parameters: dict[str, Any] = json.loads(Path(word[1:]).read_text(encoding="utf-8"))
    return parameters


class Lines:
    """A process whose output is read line by line.

    Args:
        arguments: Python's own: `-c` and a source, or `-m` and a module, and what they take.
    """

    def __init__(self, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self.seen: list[str] = []
        self._rest = b""

    def __enter__(self) -> Lines:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.process.send_signal(signal.SIGINT)  # it takes its folders and processes along
        try:
            self.process.wait(20.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()

    def wait_for(self, text: str, count: int = 1, within: float = DEADLINE) -> list[str]:
        """Read until this many lines hold a text; return them; it may take a time [s]."""
        assert self.process.stdout is not None
        descriptor, deadline = self.process.stdout.fileno(), time.monotonic() + within
        while len(self.matching(text)) < count:
            left = deadline - time.monotonic()
            ready = select.select([descriptor], [], [], max(left, 0.0))[0]
            assert ready, f"no line with {text!r} within {within} s; seen: {self.seen}"
            data = os.read(descriptor, 65536)
            assert data, f"ended without a line with {text!r}; seen: {self.seen}"
            *lines, self._rest = (self._rest + data).split(b"\n")
            self.seen += [line.decode() for line in lines]
        return self.matching(text)

    def matching(self, text: str) -> list[str]:
        """Return the lines so far that hold a text."""
        return [line for line in self.seen if text in line]

    def read_to_end(self) -> int:
        """Read what is left and return the exit code."""
        output, _ = self.process.communicate(timeout=DEADLINE)
        self.seen += (self._rest + output).decode().splitlines()
        return self.process.returncode


def ended(pid: int) -> bool:
    """Wait until a process, not a child of this one, has ended; False where it does not."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([descriptor], [], [], DEADLINE)[0])
    finally:
        os.close(descriptor)
