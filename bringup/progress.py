"""Progress on the terminal: a line that is rewritten where it can be, else one a phase."""

from __future__ import annotations

import sys
import time
from typing import TextIO

_REWRITE_PERIOD = 0.2
_BAR_WIDTH = 30


class Progress:
    """Says what goes on, with simulated time and how much faster than real it passes.

    Args:
        stream: Where to write.
    """

    def __init__(self, stream: TextIO = sys.stderr) -> None:
        self._stream = stream
        self._live = stream.isatty()
        self._start = self._last = time.monotonic()
        self._phase = ""
        self._phase_start = 0.0

    def phase(self, name: str, now: float) -> None:
        """Begin a phase at a simulated time [s]."""
        self._end_phase(now)
        self._phase, self._phase_start = name, now
        if not self._live:
            self._write(f"{now:7.1f} s  {name}\n")

    def update(self, now: float, detail: str) -> None:
        """Show the state of the phase at a simulated time [s]."""
        wall = time.monotonic()
        if self._live and wall - self._last >= _REWRITE_PERIOD:
            self._last = wall
            self._write(f"\r\033[K{self._line(now)}  {detail}")

    def finish(self, now: float) -> None:
        """End the last phase."""
        self._end_phase(now)
        self._phase = ""

    @property
    def wall_time(self) -> float:
        """Wall time since the start [s]."""
        return time.monotonic() - self._start

    def _line(self, now: float) -> str:
        return f"{now:7.1f} s  {now / max(self.wall_time, 1e-6):4.1f}x  {self._phase}"

    def _end_phase(self, now: float) -> None:
        if self._phase and self._live:
            self._write(f"\r\033[K{self._line(now)}: {now - self._phase_start:.1f} s\n")

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()


class Bar:
    """How much of a known amount is done: a bar on a terminal, else a line each tenth.

    Args:
        stream: Where to write.
    """

    def __init__(self, stream: TextIO = sys.stderr) -> None:
        self._stream = stream
        self._live = stream.isatty()
        self._last = time.monotonic()
        self._tenth = 0

    def show(self, share: float, detail: str) -> None:
        """Show a share (0..1) of the work and a few words about it."""
        if self._live:
            wall = time.monotonic()
            if wall - self._last >= _REWRITE_PERIOD:
                self._last = wall
                self._write(f"\r\033[K{self._line(share)}  {detail}")
        elif int(10.0 * share) > self._tenth:
            self._tenth = int(10.0 * share)
            self._write(f"{100.0 * share:3.0f} %  {detail}\n")

    def finish(self, detail: str) -> None:
        """Show that all is done."""
        if self._live:
            self._write(f"\r\033[K{self._line(1.0)}  {detail}\n")

    @staticmethod
    def _line(share: float) -> str:
        done = round(share * _BAR_WIDTH)
        return f"[{'#' * done}{'.' * (_BAR_WIDTH - done)}] {100.0 * share:3.0f} %"

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()
