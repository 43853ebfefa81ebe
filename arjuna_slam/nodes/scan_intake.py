"""Which scans the mapper gets: all or the newest, at what pace, with their transforms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, ScanQueue
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_ANY = 100_000  # scans; as good as all
_MANY = 10  # slam_toolbox warns from here on


class ScanIntake:
    """The scans between the topic and the mapper.

    Args:
        node: The node; its config has the parameters.

    Attributes:
        overrun: Scans left out because a newer one was there, where only the newest counts.
    """

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        c = node.config
        length = _ANY if c.synchronous else c.scan_queue_size or _ANY
        self._queue = ScanQueue(BaseFrames(node, c.odom_frame, c.base_frame, adopt=True), length)
        self._warned = False
        self.overrun = 0
        self.restart()

    def restart(self) -> None:
        """Forget the scans that wait and those that were."""
        self._queue.clear()
        self._count = 0
        self._taken: float | None = None

    def clear(self) -> None:
        """Forget the scans that wait."""
        self._queue.clear()

    def add(self, message: Any) -> None:
        """Take in a LaserScan message."""
        self._queue.add(message)
        if self._node.config.synchronous and len(self._queue) > _MANY and not self._warned:
            self._warned = True
            self._node.get_logger().warning(f"{len(self._queue)} scans wait to be processed")

    def ready(self) -> list[tuple[Scan, SE2]]:
        """Return the scans to process now, each with `T_odom_base` at its stamp."""
        due = [entry for entry in self._queue.ready() if self._due(entry[0])]
        if self._node.config.synchronous or len(due) < 2:
            return due
        self.overrun += len(due) - 1
        return due[-1:]

    def _due(self, scan: Scan) -> bool:
        """Tell whether a scan is the one in so many, and late enough after the last."""
        c = self._node.config
        self._count += 1
        if (self._count - 1) % max(c.throttle_scans, 1):
            return False
        since = c.minimum_time_interval if self._taken is None else scan.stamp - self._taken
        if 0.0 < since < c.minimum_time_interval:
            return False
        self._taken = scan.stamp
        return True


def shortened(scan: Scan, range_min: float) -> Scan:
    """Return a scan whose ranges below a least one [m] do not count."""
    return replace(scan, range_min=max(scan.range_min, range_min)) if range_min > 0.0 else scan
