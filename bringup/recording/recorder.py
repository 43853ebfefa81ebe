"""Recordings: chosen topics, byte for byte, into an mcap that rosbag2 plays."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import yaml
from mcap.writer import Writer
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.typesys import Stores, get_typestore

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.process import Process

TOPICS: dict[str, tuple[str, QoSProfile]] = {
    "/tf": ("tf2_msgs/msg/TFMessage", qos.TF),
    "/tf_static": ("tf2_msgs/msg/TFMessage", qos.TF_STATIC),
    "/robot_description": ("std_msgs/msg/String", qos.LATCHED),
    "/scan": ("sensor_msgs/msg/LaserScan", qos.SENSOR_PUBLISHER),
    "/odom": ("nav_msgs/msg/Odometry", qos.DEFAULT),
    "/imu/data": ("sensor_msgs/msg/Imu", qos.SENSOR_PUBLISHER),
    "/joint_states": ("sensor_msgs/msg/JointState", qos.DEFAULT),
    "/ground_truth/odom": ("nav_msgs/msg/Odometry", qos.DEFAULT),
    "/cmd_vel": ("geometry_msgs/msg/Twist", qos.DEFAULT),
    "/map": ("nav_msgs/msg/OccupancyGrid", qos.LATCHED),
    "/plan": ("nav_msgs/msg/Path", qos.DEFAULT),
    "/amcl_pose": ("geometry_msgs/msg/PoseWithCovarianceStamped", qos.LATCHED),
    "/initialpose": ("geometry_msgs/msg/PoseWithCovarianceStamped", qos.DEFAULT),
    "/goal_pose": ("geometry_msgs/msg/PoseStamped", qos.DEFAULT),
}
_FOREVER = {"sec": 9223372036, "nsec": 854775807}


class RecordingError(ArjunaError):
    """A recording cannot be written."""


def _offered(profile: QoSProfile) -> str:
    """Return a topic's QoS in the form rosbag2 reads it, so that latched topics stay latched."""
    latched = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    reliable = profile.reliability != ReliabilityPolicy.BEST_EFFORT
    offer = {
        "history": "keep_last",
        "depth": profile.depth,
        "reliability": "reliable" if reliable else "best_effort",
        "durability": "transient_local" if latched else "volatile",
        "deadline": _FOREVER,
        "lifespan": _FOREVER,
        "liveliness": "automatic",
        "liveliness_lease_duration": _FOREVER,
        "avoid_ros_namespace_conventions": False,
    }
    return str(yaml.safe_dump([offer], sort_keys=False))


class Recorder:
    """Writes what arrives on the topics, stamped with simulated time; a context manager.

    Args:
        process: The process to listen in.
        path: The file to write; an existing one is never overwritten.
        topics: `{topic: (type, QoS)}`; types of ROS's common interfaces.

    Raises:
        RecordingError: The file exists or cannot be written.
    """

    def __init__(
        self,
        process: Process,
        path: Path,
        topics: dict[str, tuple[str, QoSProfile]] = TOPICS,
    ) -> None:
        self._process = process
        self._file = _open_new(path)
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._writer = Writer(self._file)
        self._writer.start(profile="ros2", library="arjuna")
        self._counts: dict[int, int] = {}
        self._node = Node("recorder", context=process.context, start_parameter_services=False)
        for topic, (type_name, profile) in topics.items():
            self._subscribe(topic, type_name, profile)
        process.executor.add_node(self._node)

    def _subscribe(self, topic: str, type_name: str, profile: QoSProfile) -> None:
        package, kind, name = type_name.split("/")
        message_type = getattr(importlib.import_module(f"{package}.{kind}"), name)
        definition, _ = self._types.generate_msgdef(type_name, ros_version=2)
        schema = self._writer.register_schema(type_name, "ros2msg", definition.encode())
        metadata = {
            "offered_qos_profiles": _offered(profile),
            "topic_type_hash": self._types.hash_rihs01(type_name),
        }
        channel = self._writer.register_channel(topic, "cdr", schema, metadata)
        self._counts[channel] = 0
        self._node.create_subscription(
            message_type,
            topic,
            lambda data: self._write(channel, data),
            QoSProfile(depth=1000, durability=profile.durability, reliability=profile.reliability),
            raw=True,
        )

    def _write(self, channel: int, data: bytes) -> None:
        now = round(self._process.now * 1e9)
        self._writer.add_message(channel, now, data, now, self._counts[channel])
        self._counts[channel] += 1

    def close(self) -> None:
        """Stop listening and finish the file."""
        self._process.executor.remove_node(self._node)
        self._node.destroy_node()
        self._writer.finish()
        self._file.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _open_new(path: Path) -> BinaryIO:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("xb")
    except FileExistsError as error:
        raise RecordingError(f"{path} exists already and is not overwritten") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error
