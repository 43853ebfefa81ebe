"""Timers of one process: they fire where its clock has moved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arjuna_core.ros.local.registry import Registry


class LocalTimer:
    """What rclpy's Timer is to its owner; of several periods that pass at once one is run.

    Args:
        registry: The process's.
        period: [s].
        callback: What is called.
        clock: Whose time counts.
    """

    def __init__(
        self, registry: Registry, period: float, callback: Callable[[], Any], clock: Any
    ) -> None:
        self._registry = registry
        self._clock = clock
        self._canceled, self._last = False, 0
        self.callback = callback
        self.timer_period_ns = round(period * 1e9)
        self.reset()
        registry.timers.append(self)

    def run_due(self) -> None:
        """Queue the callback if its time has come; where time was set back, start again."""
        now = self._clock.now().nanoseconds
        if now < self._last:
            self._last = now
        if not self._canceled and now - self._last >= self.timer_period_ns:
            self._last += (now - self._last) // self.timer_period_ns * self.timer_period_ns
            self._registry.executor.put(self._call)

    def _call(self) -> None:
        if not self._canceled:
            self.callback()

    def is_canceled(self) -> bool:
        """Return whether it does not fire."""
        return self._canceled

    def cancel(self) -> None:
        """Fire no more."""
        self._canceled = True

    def reset(self) -> None:
        """Start again, now."""
        self._canceled = False
        self._last = self._clock.now().nanoseconds

    def destroy(self) -> None:
        """Leave the process."""
        self.cancel()
        if self in self._registry.timers:
            self._registry.timers.remove(self)
