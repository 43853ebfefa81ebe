"""Standing still."""

from __future__ import annotations

from arjuna_core.se2 import SE2
from arjuna_nav.behaviors.base import BehaviorResult, BehaviorStatus
from arjuna_nav.costmap.costmap import Costmap


class Wait:
    """Stands still for a time.

    Args:
        duration: How long [s].
    """

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start: float | None = None

    def tick(self, pose: SE2, costmap: Costmap | None, now: float) -> BehaviorResult:
        """Return whether the time is over; `progress` is the time left [s]."""
        if self._start is None:
            self._start = now
        left = self._duration - (now - self._start)
        status = BehaviorStatus.SUCCEEDED if left <= 0.0 else BehaviorStatus.RUNNING
        return BehaviorResult(status, progress=max(left, 0.0))
