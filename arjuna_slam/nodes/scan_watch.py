"""A node that gets no scans says so, with what there is instead."""

from __future__ import annotations

from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible

from arjuna_core.ros.node import ManagedNode

_SCAN = "sensor_msgs/msg/LaserScan"
_DRAWN = "/scan_visualization"  # slam_toolbox's own, of a keyframe
_PERIOD = 1.0  # [s] between two looks
_SILENT = 4  # looks without a scan before it is said


class ScanWatch:
    """Warns once when no scan comes, at the start or later on; made while the node configures.

    Args:
        node: The node that subscribes.
        topic: The scans' topic, as the node's parameter names it.
        profile: The subscription's quality of service.
    """

    def __init__(self, node: ManagedNode, topic: str, profile: QoSProfile) -> None:
        self._node = node
        self._topic = node.resolve_topic_name(node.process.absolute(topic))
        self._profile = profile
        self._silent = 0
        node.every(_PERIOD, self._look)

    def heard(self) -> None:
        """Note that a scan has come."""
        self._silent = 0

    def _look(self) -> None:
        self._silent += 1
        if self._silent == _SILENT:
            self._node.get_logger().warning(f"no scan comes on '{self._topic}': {self._reason()}")

    def _reason(self) -> str:
        """Return why that may be, and the cure."""
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
        """Return on which topics scans are."""
        found = [name for name, types in self._node.get_topic_names_and_types() if _SCAN in types]
        found = [name for name in found if not name.endswith(_DRAWN)]
        topics = [name for name in found if self._node.count_publishers(name)]
        if not topics:
            return "no node publishes scans: is the robot, or its lidar's driver, running?"
        return f"scans are on {', '.join(topics)}: set scan_topic, or start with --scan-topic"
