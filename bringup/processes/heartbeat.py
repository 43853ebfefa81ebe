"""Whether a process still answers: each sign of life says within what time the next one comes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PERIOD = 0.5
"""From one sign of life to the next [s]."""
PATIENCE = 6.0
"""How long a process that has work as usual may be silent [s]; one stopped for 5 s goes on."""
_NANO = 1e9


@dataclass
class Heartbeat:
    """What is known of one process's signs of life; one that gives none is not watched.

    Time that it was ready to run but got no core is not held against it: on a busy machine a
    process is late, not hung.
    """

    _heard: float | None = None
    _patience: float = PATIENCE
    _starved: float = 0.0

    def hear(self, now: float, patience: float, starved: float) -> None:
        """Take a sign of life.

        Args:
            now: On a steady clock [s].
            patience: Within what time the next one comes [s].
            starved: How long the process has waited for a core in its life [s].
        """
        self._heard, self._patience, self._starved = now, patience, starved

    def silence(self, now: float, starved: float) -> float | None:
        """Return for how long it has been silent [s] where that is too long, else None."""
        if self._heard is None:
            return None
        silent = now - self._heard - (starved - self._starved)
        return silent if silent > self._patience else None

    def excuse(self, duration: float) -> None:
        """Take no notice of a time [s] in which nobody listened."""
        if self._heard is not None:
            self._heard += duration


def starved(pid: int) -> float:
    """Return how long a process's main thread has waited for a core in its life [s]; 0 if unknown.

    Source: proc_pid_schedstat: time on the CPU, time on a run queue, time slices.
    """
    try:
        words = Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()
        return float(words[1]) / _NANO
    except (OSError, IndexError, ValueError):
        return 0.0
