"""Progress on the terminal: a line that is rewritten where it can be, else one a phase."""

from __future__ import annotations

import sys
import time
from typing import TextIO


class _Line:
    """A line that is rewritten on a terminal, at most each 0.2 s."""

    def __init__(self, stream: TextIO = sys.stderr, period: float = 0.2) -> None:
        self._stream, self._period = stream, period
        self._live = stream.isatty()
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

    def finish(self, detail: str) -> None:
        """Show that all is done."""
        self._rewrite(f"{self._bar(1.0)}  {detail}", end="\n")

    @staticmethod
    def _bar(share: float, width: int = 30) -> str:
        done = round(share * width)
        return f"[{'#' * done}{'.' * (width - done)}] {100.0 * share:3.0f} %"
