"""Which scans the mapper gets: all or the newest, at what pace, with their transforms."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible

from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.scan_queue import BaseFrames, ScanQueue
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.pose_tracker import Pace

_SCAN = "sensor_msgs/msg/LaserScan"
_DRAWN = "/scan_visualization"  # slam_toolbox's own, of a keyframe


class ScanIntake:
    """The scans between the topic and the mapper.

    Attributes:
        overrun: Scans left out because a newer one was there, where only the newest counts.
        newest: Stamp of the newest scan whose transform is known, used or not [s].
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
        self.newest = -math.inf

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
        ready = list(self._queue.ready())
        self.newest = max([self.newest, *(scan.stamp for scan, _ in ready)])
        due = [entry for entry in ready if self._pace.is_due(self._node.config, *entry)]
        if self._node.config.synchronous or len(due) < 2:
            return due
        self.overrun += len(due) - 1
        return due[-1:]


def shortened(scan: Scan, range_min: float) -> Scan:
    """Return a scan whose ranges below a least one [m] do not count."""
    return replace(scan, range_min=max(scan.range_min, range_min)) if range_min > 0.0 else scan


class ScanWatch:
    """Warns once when no scan comes, at the start or later on; made while the node configures."""

    def __init__(self, node: ManagedNode, topic: str, profile: QoSProfile) -> None:
        self._node = node
        self._topic = node.resolve_topic_name(node.process.absolute(topic))
        self._profile = profile
        self._silent = 0
        period = 1.0  # [s] between two looks
        node.every(period, self._look)

    def scan_received(self) -> None:
        """Note that a scan has come."""
        self._silent = 0

    def _look(self) -> None:
        self._silent += 1
        silent = 4  # looks without a scan
        if self._silent == silent:
            self._node.get_logger().warning(f"no scan comes on '{self._topic}': {self._reason()}")

    def _reason(self) -> str:
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        others = sorted({info.topic_type for info in publishers} - {_SCAN})
        if not publishers:
            return f"nobody publishes it; {self._elsewhere()}"
        if others:
            return f"it is of {', '.join(others)}, not {_SCAN}; {self._elsewhere()}"
        names = ", ".join(sorted({info.node_name for info in publishers}))
        for info in publishers:
            fit, reason = qos_check_compatible(info.qos_profile, self._profile)
            if fit == QoSCompatibility.ERROR:
                return f"the quality of service of {names} does not fit: {reason}"
        return f"{names} would publish it and is silent; is its lidar running?"

    def _elsewhere(self) -> str:
        found = [name for name, types in self._node.get_topic_names_and_types() if _SCAN in types]
        found = [name for name in found if not name.endswith(_DRAWN)]
        topics = [name for name in found if self._node.count_publishers(name)]
        if not topics:
            return "no node publishes scans: is the robot, or its lidar's driver, running?"
        return f"scans are on {', '.join(topics)}: set scan_topic, or start with --scan-topic"
