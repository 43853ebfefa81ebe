"""Recordings: topics, byte for byte, into files that rosbag2 plays."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock

from arjuna_core.bags.file_writer import McapWriter
from arjuna_core.bags.topic import TopicQos
from arjuna_core.bags.writer import BagFolder
from arjuna_core.ros.process import Process
from arjuna_core.timing import NANOSECONDS
from bringup.recording.listener import BARE_NODE, Received, TopicListener

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


CLOCK = "/clock"


@dataclass(frozen=True)
class RecordOptions:
    """Options of recording; what is not here is an option of the folder's.

    Attributes:
        controlled: Whether it is rosbag2's: offers its services, announces new files and logs
            its sentences.
        requested: The topics that were named, where those are all that is recorded.
        keys: Whether space pauses and resumes.
        discovery: Whether topics that appear later are recorded.
        polling_period: How often to look for them [s].
        unpublished: Whether topics without a publisher are.
        leaves: Whether topics without a subscriber are.
        sim_time: Whether messages have the time of /clock, and none is written before it comes.
        snapshot: Whether messages are held, and written when a snapshot is asked for.
        cache: Bytes to hold for that; 0 writes each message through at once.
    """

    takes: Callable[[str, str], bool] = lambda topic, type_name: True
    node_name: str = "recorder"
    controlled: bool = False
    requested: tuple[str, ...] = ()
    keys: bool = False
    overrides: Mapping[str, QoSProfile] = field(default_factory=dict)
    discovery: bool = True
    polling_period: float = 0.5
    unpublished: bool = False
    leaves: bool = True
    paused: bool = False
    sim_time: bool = False
    snapshot: bool = False
    cache: int = 100 * 1024 * 1024


class Recorder:
    """Writes received messages; `poll` it more often than a thousand messages of a topic come.

    Args:
        node: The node that listens, and is destroyed at the end.
        clock: The time to stamp messages with [s]; when they arrived if None.
    """

    def __init__(
        self,
        node: Node,
        writer: McapWriter | BagFolder,
        note: Callable[[str], None] = lambda line: None,
        clock: Callable[[], float] | None = None,
        options: RecordOptions | None = None,
    ) -> None:
        self._node = node
        self._writer = writer
        self._clock = clock
        self._note = note
        self._complete = not (options and options.requested)
        self._options = options = options or RecordOptions()
        self.listener = TopicListener(self._node, note, options.overrides)
        self.messages = 0
        self.paused = options.paused
        self._sim_time: int | None = None
        if options.sim_time:
            self.listener.listen(CLOCK, "rosgraph_msgs/msg/Clock", (TopicQos(reliable=False),))
        self._held: deque[Received] = deque()
        self._held_bytes = 0

    def discover(self) -> None:
        """Listen to the topics that are there by now; the recording lists them all."""
        options = self._options
        found = self.listener.discover(options.takes, options.unpublished, options.leaves)
        self._announce(found)
        for topic in self.listener.topics:
            if options.takes(topic.name, topic.type_name):
                self._writer.add_topic(topic)

    def _announce(self, found: Sequence[str], listed: int = 3) -> None:
        """Note the topics that were found: one by one as rosbag2, or in a line of a few names."""
        if not self._options.controlled:
            names = ", ".join(found) if len(found) <= listed else f"{len(found)} topics"
            if found:
                self._note(f"listens to {names}")
            return
        for name in found:
            self._note(f"Subscribed to topic '{name}'")
        if not self._complete and len(self.listener.topics) >= len(self._options.requested):
            self._complete = True
            self._note("All requested topics are subscribed. Stopping discovery...")

    def poll(self) -> None:
        """Write what has arrived; raise RecordingError where the disk refuses."""
        for each in self.listener.take():
            message = self._stamped(each)
            if message is None or self.paused:
                continue
            if self._options.snapshot:
                self._hold(message)
            else:
                self._write(message)

    def _stamped(self, message: Received) -> Received | None:
        """Return a message with its time; None if it is not to be recorded."""
        if self._clock is not None:
            now = round(self._clock() * 1e9)
            return Received(message.topic, now, now, message.data)
        if not self._options.sim_time:
            return message
        topic = message.topic
        if topic.name == CLOCK:
            stamp = deserialize_message(message.data, Clock).clock
            self._sim_time = stamp.sec * NANOSECONDS + stamp.nanosec
            if not self._options.takes(topic.name, topic.type_name):
                return None
        return None if self._sim_time is None else message._replace(received=self._sim_time)

    def _hold(self, message: Received) -> None:
        """Keep a message for the next snapshot; the oldest make room for it."""
        self._held.append(message)
        self._held_bytes += len(message.data)
        while self._held and self._held_bytes > self._options.cache:
            self._held_bytes -= len(self._held.popleft().data)

    def _write(self, message: Received) -> None:
        self._writer.write(message.topic, message.received, message.data, message.published)
        self.messages += 1

    def pause(self, paused: bool) -> None:
        """Pause or resume; what has arrived before belongs to the state before."""
        self.poll()
        if paused != self.paused:
            self._note("Pausing recording." if paused else "Resuming recording.")
        self.paused = paused

    def snapshot(self) -> bool:
        """Write the messages that are held; return whether there were any."""
        self.poll()
        found = len(self._held)
        while self._held:
            self._write(self._held.popleft())
        self._held_bytes = 0
        self.flush()
        return found > 0

    def flush(self) -> None:
        """Hand what has been written to the operating system."""
        self._writer.flush()

    def close(self) -> None:
        """Write what has arrived, stop listening and end the recording."""
        self.poll()
        self._node.destroy_node()
        self._writer.close(self.listener.lost)


def demo_recorder(process: Process, path: Path) -> Recorder:
    """Return a recorder of the demo's topics into one new file, stamped with simulated time.

    Raises:
        RecordingError: The file exists or cannot be written.
    """
    writer = McapWriter(path)
    node = process.make_node("recorder", spun=False, **BARE_NODE)
    recorder = Recorder(node, writer, clock=lambda: process.now)
    for topic, (type_name, offer) in TOPICS.items():
        recorder.listener.listen(topic, type_name, (offer,))
    return recorder
