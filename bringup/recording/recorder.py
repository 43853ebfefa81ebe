"""Recordings: topics, byte for byte, into files that rosbag2 plays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from rclpy.node import Node

from arjuna_core.bags.topic import TopicInfo, TopicQos
from arjuna_core.bags.writer import McapWriter
from arjuna_core.ros.process import Process
from bringup.recording.listener import Heard, TopicListener

_QUEUED, _TF, _LATCHED = TopicQos(depth=10), TopicQos(depth=100), TopicQos(latched=True, depth=1)
_SENSOR = TopicQos(depth=5)
TOPICS: dict[str, tuple[str, TopicQos]] = {
    "/tf": ("tf2_msgs/msg/TFMessage", _TF),
    "/tf_static": ("tf2_msgs/msg/TFMessage", _LATCHED),
    "/robot_description": ("std_msgs/msg/String", _LATCHED),
    "/scan": ("sensor_msgs/msg/LaserScan", _SENSOR),
    "/odom": ("nav_msgs/msg/Odometry", _QUEUED),
    "/imu/data": ("sensor_msgs/msg/Imu", _SENSOR),
    "/joint_states": ("sensor_msgs/msg/JointState", _QUEUED),
    "/ground_truth/odom": ("nav_msgs/msg/Odometry", _QUEUED),
    "/cmd_vel": ("geometry_msgs/msg/Twist", _QUEUED),
    "/map": ("nav_msgs/msg/OccupancyGrid", _LATCHED),
    "/plan": ("nav_msgs/msg/Path", _QUEUED),
    "/amcl_pose": ("geometry_msgs/msg/PoseWithCovarianceStamped", _LATCHED),
    "/initialpose": ("geometry_msgs/msg/PoseWithCovarianceStamped", _QUEUED),
    "/goal_pose": ("geometry_msgs/msg/PoseStamped", _QUEUED),
}
"""What the demo records: with these the lock-step run listens from its first tick on."""

OPTIONS: dict[str, Any] = {"start_parameter_services": False, "enable_rosout": False}
"""Of the recorder's node."""


class Writer(Protocol):
    """Where messages go."""

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message; see `McapWriter.write`."""

    def flush(self) -> None:
        """Hand everything to the operating system."""

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """End the recording."""


class Recorder:
    """Writes what is heard; `poll` it more often than a thousand messages of a topic come.

    Args:
        node: The node that listens, and is destroyed at the end.
        writer: Where the messages go.
        note: Takes lines about topics.
        clock: The time to stamp messages with [s]; when they arrived if None.

    Attributes:
        listener: The topics.
        messages: How many messages have been written.
    """

    def __init__(
        self,
        node: Node,
        writer: Writer,
        note: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self._node = node
        self._writer = writer
        self._clock = clock
        self.listener = TopicListener(self._node, note)
        self.messages = 0

    def poll(self) -> None:
        """Write what has arrived.

        Raises:
            RecordingError: The disk refuses.
        """
        for heard in self.listener.take():
            self._write(heard)

    def _write(self, heard: Heard) -> None:
        if self._clock is None:
            time, published = heard.received, heard.published
        else:
            time = published = round(self._clock() * 1e9)
        self._writer.write(heard.topic, time, heard.data, published)
        self.messages += 1

    def flush(self) -> None:
        """Hand what has been written to the operating system."""
        self._writer.flush()

    def close(self) -> None:
        """Write what has arrived, stop listening and end the recording."""
        self.poll()
        self._node.destroy_node()
        self._writer.close(self.listener.lost)


def demo_recorder(process: Process, path: Path) -> Recorder:
    """Return a recorder of the demo's topics into one file, stamped with simulated time.

    Args:
        process: The lock-step process.
        path: The file to write; an existing one is never overwritten.

    Raises:
        RecordingError: The file exists or cannot be written.
    """
    writer = McapWriter(path)
    node = process.make_node("recorder", spun=False, **OPTIONS)
    recorder = Recorder(node, writer, clock=lambda: process.now)
    for topic, (type_name, offer) in TOPICS.items():
        recorder.listener.listen(topic, type_name, (offer,))
    return recorder
