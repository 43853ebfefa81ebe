"""Keeping simulated time in step with a wall clock, for people to watch."""

from __future__ import annotations

from collections.abc import Callable


class Pacer:
    """Says how long to wait so that simulated time runs at a factor of real time.

    Args:
        factor: Simulated seconds per real second; 0 is as fast as it goes.
        clock: Returns real time [s].

    Raises:
        ValueError: The factor is negative.
    """

    def __init__(self, factor: float, clock: Callable[[], float]) -> None:
        if not factor >= 0.0:
            raise ValueError(f"real-time factor must be at least 0, got {factor}")
        self._factor = factor
        self._clock = clock
        self._start: tuple[float, float] | None = None

    def restart(self) -> None:
        """Restart with the next wait: after a pause, a reset or a jump of time."""
        self._start = None

    def wait(self, now: float) -> float:
        """Return how long to wait [real s] before simulated time may pass `now` [s]."""
        if self._factor == 0.0:
            return 0.0
        real = self._clock()
        if self._start is None:
            self._start = (real, now)
        ahead = self._start[0] + (now - self._start[1]) / self._factor - real
        if ahead < -0.5:  # [real s] what is farther behind is not caught up with
            self._start = (real, now)
        return max(0.0, ahead)


class PaceMeter:
    """Measures the real-time factor that is achieved."""

    def __init__(self, period: float = 1.0) -> None:
        self._period = period
        self._since: tuple[float, float] | None = None
        self._real = 0.0
        self._simulated = 0.0

    def pause(self) -> None:
        """Count no real time until the next `update`."""
        self._since = None

    def update(self, real: float, simulated: float) -> float | None:
        """Take both times; return the factor since the last reading, where one is due.

        Args:
            real: Real time on any steady clock [s].
            simulated: Simulated time that has passed in all, which never falls [s].
        """
        if self._since is None:
            self._since = (real, simulated)
        passed = real - self._since[0]
        if passed < self._period:
            return None
        gained = simulated - self._since[1]
        self._since = (real, simulated)
        self._real += passed
        self._simulated += gained
        return gained / passed

    @property
    def summary(self) -> str | None:
        """The factor that was achieved in all, in words; None where nothing was measured."""
        if self._real == 0.0:
            return None
        factor = self._simulated / self._real
        return f"real-time factor {factor:.2f}: {self._simulated:.1f} s in {self._real:.1f} s"
