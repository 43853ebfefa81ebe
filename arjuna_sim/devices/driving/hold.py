"""How long a velocity command holds: by the period of whoever sends them."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

ASSUMED = 1.0
"""Period of a sender of whom one command is known: `ros2 topic pub`'s default [s]."""
_LATE = 1.5  # of its period: a command ends where the next one is so late
_EARLY = 1.2  # of its period: no sooner is the next one taken not to come
_KEPT = 5  # gaps, of which the longest is the period: two senders at 1 Hz may take turns
_BRAKES = 0.4  # of the time-out, at most, by which braking begins before it is out


@dataclass(frozen=True)
class HoldLimits:
    """Bounds of a command's hold.

    Attributes:
        least: A command holds so long at least; for ever if 0 [s].
        longest: And so long at most, unless `least` is longer [s].
        is_fixed: Whether each holds just `least`, and braking begins when that is out.
    """

    least: float = 0.5
    longest: float = 3.0
    is_fixed: bool = False


class CommandHold:
    """When the last command ends.

    A command holds for one and a half periods of its sender, within the limits. The period is the
    longest of the last five gaps between commands: a quick sender that falls silent ends after the
    least time, a slow one never between two commands. After a silence that ended a command the
    period is unknown: it is that silence, or a second if that is more. So is the first command's.

    Only the times of commands count, so that it is the same whoever sends them, and in each run.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all commands."""
        self._gaps: deque[float] = deque(maxlen=_KEPT)
        self._last = self._ends = -math.inf
        self._room = 0.0

    def take(self, now: float, limits: HoldLimits) -> None:
        """Take a command at a time [s]."""
        gap = now - self._last
        if gap < 0.0 or now >= self._ends:
            self._gaps.clear()
            gap = max(gap, ASSUMED) if 0.0 <= gap <= limits.longest else ASSUMED
        self._gaps.append(gap)
        period = max(self._gaps)
        hold = max(limits.least, min(_LATE * period, limits.longest))
        if limits.is_fixed or not limits.least:
            hold = limits.least or math.inf
        self._last, self._ends = now, now + hold
        room = min(_BRAKES * limits.least, hold - _EARLY * period)
        self._room = 0.0 if limits.is_fixed else max(0.0, room)

    def ends(self, braking: float) -> float:
        """Return when the last command ends for a robot that takes some time to stand [s].

        It stands when the command is out where it can, without braking before the next is due.
        """
        return self._ends - min(braking, self._room)
