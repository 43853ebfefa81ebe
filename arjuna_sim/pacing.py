"""Keeping simulated time in step with a wall clock, for people to watch."""

from __future__ import annotations

from collections.abc import Callable


class Pacer:
    """Says how long to wait so that simulated time runs at a factor of real time.

    Args:
        factor: Simulated seconds per real second; 0 is as fast as it goes.
        clock: Returns real time [s].
        slack: How far it may fall behind before it gives up catching up [real s].

    Raises:
        ValueError: The factor is negative.
    """

    def __init__(self, factor: float, clock: Callable[[], float], slack: float = 0.5) -> None:
        if not factor >= 0.0:
            raise ValueError(f"real-time factor must be at least 0, got {factor}")
        self._factor = factor
        self._clock = clock
        self._slack = slack
        self._start: tuple[float, float] | None = None

    def restart(self) -> None:
        """Begin anew with the next wait: after a pause, a reset or a jump of time."""
        self._start = None

    def wait(self, now: float) -> float:
        """Return how long to wait [real s] before simulated time may pass `now` [s]."""
        if self._factor == 0.0:
            return 0.0
        real = self._clock()
        if self._start is None:
            self._start = (real, now)
        ahead = self._start[0] + (now - self._start[1]) / self._factor - real
        if ahead < -self._slack:
            self._start = (real, now)
        return max(0.0, ahead)
