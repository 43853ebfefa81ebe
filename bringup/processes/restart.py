"""How soon a process that died starts again, and when to give up."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from arjuna_core.config import param


@dataclass(frozen=True)
class RestartLimits:
    """When a process that dies again and again, without ever coming up, is left alone."""

    first_delay: float = param(0.2, "Wait before the first restart; doubles", unit="s", minimum=0.0)
    deaths: int = param(5, "Deaths within the window that end the attempts", minimum=1)
    window: float = param(60.0, "How long a death counts", unit="s", minimum=0.0)


@dataclass
class RestartPolicy:
    """The deaths of one process, on whatever clock `now` comes from.

    Attributes:
        limits: Delays and when to give up.
    """

    limits: RestartLimits = RestartLimits()
    _deaths: deque[float] = field(default_factory=deque)

    def on_death(self, now: float, was_up: bool = False) -> float | None:
        """Count a death.

        Args:
            now: When it died [s].
            was_up: Whether it had come up; what went before then counts no longer.

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
