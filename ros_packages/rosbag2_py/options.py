"""The values that rosbag2_py's readers and writers take and return.

A name that an option does not have is an AttributeError, as in the original.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, auto

import rclpy.duration
from rclpy.qos import QoSProfile
from rclpy.time import Time

from rosbag2_py.qos import Duration as Duration  # the original has these beside its options
from rosbag2_py.qos import QoS as QoS
from rosbag2_py.qos import convert_rclcpp_qos_to_rclpy_qos as convert_rclcpp_qos_to_rclpy_qos
from rosbag2_py.qos import rmw_qos_durability_policy_t as rmw_qos_durability_policy_t
from rosbag2_py.qos import rmw_qos_history_policy_t as rmw_qos_history_policy_t
from rosbag2_py.qos import rmw_qos_liveliness_policy_t as rmw_qos_liveliness_policy_t
from rosbag2_py.qos import rmw_qos_reliability_policy_t as rmw_qos_reliability_policy_t
from rosbag2_py.qos import to_rclcpp_qos_vector as to_rclcpp_qos_vector


@dataclass(slots=True)
class StorageOptions:
    """The path of a recording, and its form."""

    uri: str
    storage_id: str = ""
    max_bagfile_size: int = 0
    max_bagfile_duration: int = 0
    max_cache_size: int = 0
    storage_preset_profile: str = ""
    storage_config_uri: str = ""
    snapshot_mode: bool = False
    start_time_ns: int = -1
    end_time_ns: int = -1
    custom_data: dict[str, str] = field(default_factory=dict)


@dataclass(slots=True)
class ConverterOptions:
    """Encodings of messages; there is only cdr."""

    input_serialization_format: str = ""
    output_serialization_format: str = ""


@dataclass(slots=True)
class StorageFilter:
    """The topics that are read; an expression fits the whole name."""

    topics: list[str] = field(default_factory=list)
    services_events: list[str] = field(default_factory=list)
    regex: str = ""
    exclude_topics: list[str] = field(default_factory=list)
    exclude_service_events: list[str] = field(default_factory=list)
    regex_to_exclude: str = ""


@dataclass(slots=True)
class TopicMetadata:
    """A topic; what it offered may be given as text, as before Jazzy."""

    id: int = 0
    name: str = ""
    type: str = ""
    serialization_format: str = "cdr"
    offered_qos_profiles: Sequence[QoS | QoSProfile] | str = field(default_factory=list)
    type_description_hash: str = ""

    def equals(self, other: TopicMetadata) -> bool:
        return self == other

    def profiles(self) -> list[QoSProfile]:
        """Return what its publishers offered, as rclpy's profiles."""
        given = self.offered_qos_profiles
        offers = to_rclcpp_qos_vector(given) if isinstance(given, str) else given
        return [convert_rclcpp_qos_to_rclpy_qos(each) for each in offers]


@dataclass
class TopicInformation:
    """A topic and how many messages it has."""

    topic_metadata: TopicMetadata
    message_count: int


@dataclass
class MessageDefinition:
    """A type's definition."""

    topic_type: str
    encoding: str
    encoded_message_definition: str
    type_hash: str


@dataclass
class FileInformation:
    """A file of a recording."""

    path: str
    starting_time: Time
    duration: rclpy.duration.Duration
    message_count: int


@dataclass
class BagMetadata:
    """A recording in short; as text it is what `ros2 bag info` prints."""

    version: int
    bag_size: int
    storage_identifier: str
    relative_file_paths: list[str]
    files: list[FileInformation]
    duration: rclpy.duration.Duration
    starting_time: Time
    message_count: int
    topics_with_message_count: list[TopicInformation]
    compression_format: str = ""
    compression_mode: str = ""
    custom_data: dict[str, str] = field(default_factory=dict)
    ros_distro: str = ""
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return self.text


class ReadOrderSortBy(Enum):
    """The order of messages."""

    ReceivedTimestamp = auto()
    PublishedTimestamp = auto()
    File = auto()


@dataclass
class ReadOrder:
    """The order in which messages are read."""

    sort_by: ReadOrderSortBy = ReadOrderSortBy.ReceivedTimestamp
    reverse: bool = False


class CompressionMode(Enum):
    """The unit that is compressed."""

    NONE = auto()
    FILE = auto()
    MESSAGE = auto()


@dataclass(slots=True)
class CompressionOptions:
    """The compression of a recording."""

    compression_format: str = ""
    compression_mode: CompressionMode = CompressionMode.NONE
    compression_queue_size: int = 0
    compression_threads: int = 0
    thread_priority: int | None = None


def compression_mode_from_string(mode: str) -> CompressionMode:
    """Return the mode of a name; that of an unknown one is NONE."""
    known = CompressionMode.__members__
    return known.get(mode.upper(), CompressionMode.NONE)


def compression_mode_to_string(mode: CompressionMode) -> str:
    return mode.name


def get_registered_readers() -> set[str]:
    return {"mcap", "sqlite3"}


def get_registered_writers() -> set[str]:
    return {"mcap", "sqlite3"}


def get_registered_compressors() -> set[str]:
    return {"zstd"}


def get_registered_serializers() -> set[str]:
    return {"cdr_converter"}


def get_default_storage_id() -> str:
    return "mcap"
