"""Rates on a clock that is handed in: never wall time."""

from __future__ import annotations

import math

NANOSECONDS = 1_000_000_000  # in a second


class Periodic:
    """Says when something that repeats is due, without drift, on whatever clock `now` comes from.

    Args:
        period: Time between two occurrences [s].
        phase: Time of the first occurrence [s].

    Attributes:
        next: Time before which none comes [s].

    Raises:
        ValueError: The period is not positive.
    """

    def __init__(self, period: float, phase: float = 0.0) -> None:
        if not period > 0.0:
            raise ValueError(f"period must be positive, got {period}")
        self._period = period
        self._phase = phase
        self._count = 0
        self._last = self.next = -math.inf

    def due(self, now: float) -> bool:
        """Return whether an occurrence has come since the last call that said so."""
        if self._last <= now < self.next:
            return False
        # 1 ns for rounding.
        count = int((now - self._phase + 1e-9) // self._period) + 1
        if count < self._count:  # the clock was set back
            self._count = max(count - 1, 0)
            self._last = self.next = -math.inf
        if count <= self._count:
            return False
        self._count = count
        # 1 us of rounding, which near the ends of a period is left to the division.
        self._last = self._phase + (count - 1) * self._period + 1e-6
        self.next = self._phase + count * self._period - 1e-6
        return True


def other_clock(age: float) -> str:
    """Return the remedy where a stamp's age [s] shows that two clocks are in use, else nothing."""
    # Simulated time begins near 0, the system's in 1970: 1e6 s are no delay.
    if abs(age) < 1e6:
        return ""
    simulated, system, who = "simulated time", "the system's", "this node"
    if age < 0.0:
        simulated, system, who = system, simulated, "its sender"
    return (
        f"it is of {simulated}, this node's clock is {system}: start {who} with use_sim_time:=true"
    )
