"""Rates on a clock that is handed in: never wall time."""

from __future__ import annotations

_TOLERANCE = 1e-9


class Periodic:
    """Says when something that repeats is due, without drift, on whatever clock `now` comes from.

    Args:
        period: Time between two occurrences [s].
        phase: Time of the first occurrence [s].

    Raises:
        ValueError: The period is not positive.
    """

    def __init__(self, period: float, phase: float = 0.0) -> None:
        if not period > 0.0:
            raise ValueError(f"period must be positive, got {period}")
        self._period = period
        self._phase = phase
        self._count = 0

    def due(self, now: float) -> bool:
        """Tell whether an occurrence has come since the last call that said so."""
        count = int((now - self._phase + _TOLERANCE) // self._period) + 1
        if count < self._count:  # the clock was set back
            self._count = max(count - 1, 0)
        if count <= self._count:
            return False
        self._count = count
        return True
