"""When a process is ended because it is silent, and how soon one that died starts again."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.config import duration_param, param

PERIOD = 0.5
"""From one sign of life to the next [s]."""
PATIENCE = 6.0
"""The longest silence of a process at its usual work [s]; one stopped for 5 s continues."""


@dataclass
class Heartbeat:
    """One process's signs of life; one that gives none is not watched.

    Time that it was ready to run but got no core is not held against it: on a busy machine a
    process is late, not stuck.
    """

    _last_sign: float | None = None
    _patience: float = PATIENCE
    _starved: float = 0.0

    def hear(self, now: float, patience: float, starved: float) -> None:
        """Take a sign of life.

        Args:
            now: On a steady clock [s].
            patience: Within what time the next one comes [s].
            starved: How long the process has waited for a core in its life [s].
        """
        self._last_sign, self._patience, self._starved = now, patience, starved

    def silence(self, now: float, starved: float) -> float | None:
        """Return for how long it has been silent [s] where that is too long, else None."""
        if self._last_sign is None:
            return None
        silent = now - self._last_sign - (starved - self._starved)
        return silent if silent > self._patience else None

    def excuse(self, duration: float) -> None:
        """Take no notice of a time [s] in which nobody listened."""
        if self._last_sign is not None:
            self._last_sign += duration


def starved(pid: int) -> float:
    """Return how long a process's main thread has waited for a core in its life [s]; 0 if unknown.

    Source: proc_pid_schedstat: time on the CPU, time on a run queue, time slices.
    """
    try:
        words = Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()
        return float(words[1]) / 1e9
    except (OSError, IndexError, ValueError):
        return 0.0


@dataclass(frozen=True)
class RestartLimits:
    """When a process that dies again and again, without ever coming up, is left alone."""

    first_delay: float = duration_param(0.2, "Wait before the first restart; doubles")
    deaths: int = param(5, "Deaths within the window that end the attempts", minimum=1)
    window: float = duration_param(60.0, "How long a death counts")


@dataclass
class RestartPolicy:
    """The deaths of one process, on whatever clock `now` comes from."""

    limits: RestartLimits = RestartLimits()
    _deaths: deque[float] = field(default_factory=deque)

    def on_death(self, now: float, was_up: bool = False) -> float | None:
        """Count a death at a time [s]; one that `was_up` forgets what went before.

        Returns:
            How long to wait before it starts again [s]: doubled each time; None to give up.
        """
        if was_up:
            self._deaths.clear()
        while self._deaths and now - self._deaths[0] > self.limits.window:
            self._deaths.popleft()
        self._deaths.append(now)
        if len(self._deaths) >= self.limits.deaths:
            return None
        return float(self.limits.first_delay * 2 ** (len(self._deaths) - 1))
