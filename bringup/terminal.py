"""The terminal: lines and progress for its user, and the keys and signals that come from there."""

from __future__ import annotations

import os
import select
import signal
import sys
import termios
import threading
import time
import tty
from typing import Any, TextIO

from bringup.interrupts import was_interrupted


def show(line: str) -> None:
    """Print a line; where nobody reads any more, as after `| head`, stop."""
    write(f"{line}\n")


def write(text: str) -> None:
    """Print a text without a line's end; where nobody reads any more, stop."""
    try:
        print(text, end="", flush=True)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123 - for the rest of the process
        os.kill(os.getpid(), signal.SIGTERM)


def is_read() -> bool:
    """Return whether a page of output would be taken now: not by a full pipe or a held terminal."""
    try:
        return bool(select.select([], [sys.stdout], [], 0.0)[1])
    except (OSError, ValueError):  # no file of the system's
        return True


def stopped_by_signals() -> threading.Event:
    """Return an event that Ctrl-C and a request to terminate set, from now on."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    if was_interrupted():
        stop.set()
    return stop


UP, DOWN, RIGHT, LEFT = (f"\x1b[{letter}" for letter in "ABCD")
"""What a terminal sends for the arrow keys."""


class Keys:
    """Reads single keys from standard input where that is a terminal; a context manager.

    Args:
        raw: Whether keys that send signals, such as Ctrl-C, are read as keys too.

    Attributes:
        live: Whether there is a terminal.
    """

    def __init__(self, raw: bool = False) -> None:
        self._set_mode = tty.setraw if raw else tty.setcbreak
        self._descriptor = -1
        self._before: list[Any] = []
        self.live = sys.stdin is not None and sys.stdin.isatty()

    def __enter__(self) -> Keys:
        if self.live:
            self._descriptor = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._descriptor)
            self._set_mode(self._descriptor)
        return self

    def __exit__(self, *ended: object) -> None:
        if self.live:
            termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def waits(self, timeout: float = 0.0) -> bool:
        """Return whether a key has been pressed, at the latest after a time [s]."""
        inputs = [self._descriptor] if self.live else []
        return bool(select.select(inputs, [], [], timeout)[0])

    def wait(self, timeout: float) -> str:
        """Return the key that is pressed within a time [s], "" where there is none."""
        if not self.waits(timeout):
            return ""
        key = os.read(self._descriptor, 1)
        if key == b"\x1b" and self.waits():  # an arrow, not the key itself
            key += os.read(self._descriptor, 2)
        return key.decode("latin-1")


class _Line:
    """A line that is rewritten on a terminal, at most each 0.2 s."""

    def __init__(self, stream: TextIO | None = None, period: float = 0.2) -> None:
        self._stream, self._period = stream or sys.stderr, period
        self._live = self._stream.isatty()
        self._start = self._last = time.monotonic()

    def _rewrite(self, text: str, end: str = "") -> None:
        wall = time.monotonic()
        if self._live and (end or wall - self._last >= self._period):
            self._last = wall
            self._write(f"\r\033[K{text}{end}")

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()


class Progress(_Line):
    """Shows the phase, with simulated time and how much faster than real it passes."""

    _phase, _phase_start = "", 0.0

    def phase(self, name: str, now: float) -> None:
        """Begin a phase at a simulated time [s]."""
        self.finish(now)
        self._phase, self._phase_start = name, now
        if not self._live:
            self._write(f"{now:7.1f} s  {name}\n")

    def update(self, now: float, detail: str) -> None:
        """Show the state of the phase at a simulated time [s]."""
        self._rewrite(f"{self._line(now)}  {detail}")

    def finish(self, now: float) -> None:
        """End the last phase."""
        if self._phase:
            self._rewrite(f"{self._line(now)}: {now - self._phase_start:.1f} s", end="\n")
        self._phase = ""

    @property
    def wall_time(self) -> float:
        """Wall time since the start [s]."""
        return time.monotonic() - self._start

    def _line(self, now: float) -> str:
        return f"{now:7.1f} s  {now / max(self.wall_time, 1e-6):4.1f}x  {self._phase}"


class Bar(_Line):
    """The share of a known amount that is done: a bar on a terminal, else a line each tenth."""

    _tenth = 0

    def show(self, share: float, detail: str) -> None:
        """Show a share (0..1) of the work and a few words about it."""
        self._rewrite(f"{self._bar(share)}  {detail}")
        if not self._live and int(10.0 * share) > self._tenth:
            self._tenth = int(10.0 * share)
            self._write(f"{100.0 * share:3.0f} %  {detail}\n")

    def clear(self) -> None:
        """Take the line off a terminal, for others to be written there."""
        if self._live:
            self._write("\r\033[K")

    def finish(self, detail: str) -> None:
        """Show that all is done."""
        self._rewrite(f"{self._bar(1.0)}  {detail}", end="\n")

    @staticmethod
    def _bar(share: float, width: int = 30) -> str:
        done = round(share * width)
        return f"[{'#' * done}{'.' * (width - done)}] {100.0 * share:3.0f} %"
