"""The scans that the mapper gets: all or the newest, at what pace, with their transforms."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan

from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, ScanQueue
from arjuna_core.ros.silence import Silence, subscribe_watched
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.pose_tracker import Pace


class ScanIntake:
    """The scans between the topic and the mapper.

    Attributes:
        overrun: Scans left out because a newer one was there, where only the newest counts.
        passed_over: Stamp of the newest scan that its pace left out, whose transform is known [s].
    """

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        c = node.config
        any_number = 100_000  # of scans, as good as all
        length = any_number if c.synchronous else c.scan_queue_size or any_number
        self._queue = ScanQueue(BaseFrames(node, c.odom_frame, c.base_frame, adopt=True), length)
        self._warned = False
        self.overrun = 0
        self.restart()

    def restart(self) -> None:
        """Forget the scans that wait and those that were."""
        self._queue.clear()
        self._pace = Pace()
        self.passed_over = -math.inf

    def clear(self) -> None:
        """Forget the scans that wait."""
        self._queue.clear()

    def add(self, message: Any) -> None:
        """Take in a LaserScan message."""
        self._queue.add(message)
        many = 10  # scans; slam_toolbox warns from here on
        if self._node.config.synchronous and len(self._queue) > many and not self._warned:
            self._warned = True
            self._node.get_logger().warning(f"{len(self._queue)} scans wait to be processed")

    def ready(self) -> list[tuple[Scan, SE2]]:
        """Return the scans to process now, each with `T_odom_base` at its stamp."""
        due: list[tuple[Scan, SE2]] = []
        for entry in self._queue.ready():
            if self._pace.is_due(self._node.config, *entry):
                due.append(entry)
            else:
                self.passed_over = entry[0].stamp
        if self._node.config.synchronous or len(due) < 2:
            return due
        self.overrun += len(due) - 1
        return due[-1:]


def shortened(scan: Scan, range_min: float) -> Scan:
    """Return a scan whose ranges below a least one [m] do not count."""
    return replace(scan, range_min=max(scan.range_min, range_min)) if range_min > 0.0 else scan


def subscribe_scans(
    node: ManagedNode, topic: str, profile: QoSProfile, take: Callable[[Any], None]
) -> None:
    """Subscribe to scans in a node's `configure`, and warn where none comes."""
    advice = "set scan_topic, or start with --scan-topic"
    subscribe_watched(node, topic, Silence(LaserScan, "scan", profile, advice), take)
