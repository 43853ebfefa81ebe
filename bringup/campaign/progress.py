"""A campaign's progress on the terminal: a line a run, and one of how far all are."""

from __future__ import annotations

import time

from bringup.campaign.outcome import Outcome
from bringup.campaign.pool import Ended, Pool
from bringup.terminal import Bar, show


class Progress:
    """Shows how runs end, how many run, and when the last will have."""

    def __init__(self, count: int, pool: Pool) -> None:
        self._count, self._pool = count, pool
        self._done = self._lost = self._before = 0
        self._start = float("nan")
        self._bar = Bar()

    def ended(self, outcome: Outcome) -> None:
        """Show how a run ended."""
        self._done += 1
        verdict = "ok" if outcome.success else f"FAILED: {outcome.reason}"
        line = f"{self._done:5} of {self._count}  {outcome.name:40} {outcome.wall_s:7.1f} s"
        self._bar.clear()
        show(f"{line}  {verdict}")

    def lost(self, end: Ended) -> None:
        """Show that a run was given up."""
        self._lost += 1
        self._bar.clear()
        show(f"LOST  {end.job.run.name}: {end.cause}; the same words try it again")

    def show(self, going: int) -> None:
        """Show how far all are, while some have started and not ended."""
        now = time.monotonic()
        if self._start != self._start:
            self._start, self._before = now, self._done
        minutes = (now - self._start) / 60.0
        rate = (self._done - self._before) / max(minutes, 1e-3)
        remaining = self._count - self._done - self._lost
        end = f", ends in {remaining / rate:.0f} min" if rate > 0.0 else ""
        running = min(going, self._pool.slots)
        self._bar.show(
            (self._done + self._lost) / self._count,
            f"{self._done} done, {running} running, {self._lost} lost, {rate:.1f} a minute{end}",
        )
