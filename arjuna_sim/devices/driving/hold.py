"""How long a velocity command holds: by the period of whoever sends them."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

ASSUMED = 1.0
"""Period of a sender of whom one command is known: `ros2 topic pub`'s default [s]."""
_LATE = 1.5  # of its period: a command ends where the next one is so late
_EARLY = 1.2  # of its period: no sooner is the next one taken not to come
_KEPT, _RANK = 9, 3  # gaps: of three senders that take turns a third are long
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

    A command holds for one and a half periods of its sender, within the limits: a quick sender that
    falls silent ends after the least time, a slow one never between two commands. The period is the
    third longest of the last nine gaps between commands, so that two late ones do not make a quick
    sender slow, and three slow senders that take turns are not taken for a quick one. It is unknown
    of the first command, and of one after more than one and a half seconds of silence in which the
    last one ended: then it is that silence, or a second where the limits do not allow for it.

    Only the times of commands count, so that it is the same whoever sends them, and in each run.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all commands."""
        self._gaps: deque[float] = deque(maxlen=_KEPT)
        self._last = self._ends = -math.inf
        self._room, self._assumed = 0.0, ASSUMED

    def take(self, now: float, limits: HoldLimits) -> None:
        """Take a command at a time [s]."""
        gap = now - self._last
        if (now >= self._ends and gap >= _LATE * ASSUMED) or gap < 0.0:
            self._gaps.clear()
            self._assumed = gap if 0.0 < gap <= limits.longest else ASSUMED
        else:
            self._gaps.append(gap)
        period = sorted(self._gaps or [self._assumed])[-_RANK:][0]
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
