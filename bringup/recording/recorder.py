"""Recordings: topics, byte for byte, into files that rosbag2 plays."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

from rclpy.node import Node

from arjuna_core.bags.topic import TopicQos
from arjuna_core.bags.writer import BagFolder, McapWriter, SplitLimits
from arjuna_core.ros.context import new_context
from arjuna_core.ros.process import Process
from bringup.recording.listener import BARE_NODE, TopicListener
from bringup.recording.selection import TopicSelection
from bringup.terminal import stopped_by_signals

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
"""The topics that the demo records: with these the lock-step run listens from its first tick on."""


class Recorder:
    """Writes received messages; `poll` it more often than a thousand messages of a topic come.

    Args:
        node: The node that listens, and is destroyed at the end.
        writer: Where the messages go.
        note: Takes lines about topics.
        clock: The time to stamp messages with [s]; when they arrived if None.

    Attributes:
        messages: How many messages have been written.
    """

    def __init__(
        self,
        node: Node,
        writer: McapWriter | BagFolder,
        note: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self._node = node
        self._writer = writer
        self._clock = clock
        self.listener = TopicListener(self._node, note)
        self.messages = 0

    def poll(self) -> None:
        """Write what has arrived; raise RecordingError where the disk refuses."""
        for topic, received, published, data in self.listener.take():
            if self._clock is not None:
                received = published = round(self._clock() * 1e9)
            self._writer.write(topic, received, data, published)
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
        path: The file to write; an existing one is never overwritten.

    Raises:
        RecordingError: The file exists or cannot be written.
    """
    writer = McapWriter(path)
    node = process.make_node("recorder", spun=False, **BARE_NODE)
    recorder = Recorder(node, writer, clock=lambda: process.now)
    for topic, (type_name, offer) in TOPICS.items():
        recorder.listener.listen(topic, type_name, (offer,))
    return recorder


def record(
    folder: Path, selection: TopicSelection, limits: SplitLimits, show: Callable[[str], None]
) -> None:
    """Record the chosen topics until SIGINT or SIGTERM.

    Args:
        folder: Where to; it must not exist.

    Raises:
        RecordingError: The folder exists, or the disk refuses.
    """
    bag = BagFolder(folder, limits)
    stop = stopped_by_signals()
    context = new_context()
    recorder = Recorder(Node("recorder", context=context, **BARE_NODE), bag, show)
    show(f"records into {folder}; Ctrl-C ends it")
    try:
        _run(recorder, selection, stop)
    finally:
        recorder.close()
        context.shutdown()
        show(_summary(recorder))


def _run(
    recorder: Recorder,
    selection: TopicSelection,
    stop: threading.Event,
    poll_period: float = 0.02,
    discovery_period: float = 0.5,
    flush_period: float = 1.0,
) -> None:
    """Record until stopped; a recorder that is killed loses at most one flush period [s]."""
    discover = flush = time.monotonic()
    while not stop.is_set():
        now = time.monotonic()
        if now >= discover:
            recorder.listener.discover(selection.takes)
            discover = now + discovery_period
        recorder.poll()
        if now >= flush:
            recorder.flush()
            flush = now + flush_period
        stop.wait(poll_period)


def _summary(recorder: Recorder) -> str:
    listener = recorder.listener
    text = f"{recorder.messages} messages of {len(listener.topics)} topics, "
    lost = ", ".join(f"{topic}: {count}" for topic, count in listener.lost.items())
    return text + (f"of those published these were lost: {lost}" if lost else "none lost")
