"""Descriptions of a recording: its metadata.yaml, and the definitions of its types."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from arjuna_core.bags.metadata import METADATA, FileEntry, metadata_yaml
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.ros.qos import qos_of
from bringup.recording.message_definitions import installed_type
from rosbag2_py.options import BagMetadata, FileInformation, MessageDefinition, TopicMetadata
from rosbag2_py.reader import Info


class LocalMessageDefinitionSource:
    """Finds the definitions of installed types."""

    def get_full_text(self, root_topic_type: str) -> MessageDefinition:
        """Return a type's definition; its encoding is `unknown` where it is not installed."""
        text, type_hash = installed_type(root_topic_type)
        return MessageDefinition(root_topic_type, "ros2msg" if text else "unknown", text, type_hash)


class MetadataIo:
    """Reads and writes the metadata.yaml of a recording's folder."""

    def metadata_file_exists(self, uri: str) -> bool:
        return _path(uri).is_file()

    def read_metadata(self, uri: str) -> BagMetadata:
        """Return a recording in short.

        Raises:
            RuntimeError: It has no metadata.yaml, or cannot be read.
        """
        if not self.metadata_file_exists(uri):
            raise RuntimeError(f"{_path(uri)} does not exist")
        return Info().read_metadata(uri)

    def write_metadata(self, uri: str, metadata: BagMetadata) -> None:
        """Write metadata.yaml again.

        Raises:
            RuntimeError: The disk refuses.
        """
        try:
            write_atomically(_path(uri), self.serialize_metadata(metadata).encode())
        except OSError as error:
            raise RuntimeError(f"{_path(uri)} cannot be written: {error.strerror}") from error

    def serialize_metadata(self, metadata: BagMetadata) -> str:
        """Return the text of a metadata.yaml, of Jazzy's version 9."""
        every = metadata.topics_with_message_count
        counts = Counter({each.topic_metadata.name: each.message_count for each in every})
        topics = [_topic(each.topic_metadata) for each in every]
        return metadata_yaml(
            *(topics, [_entry(each) for each in metadata.files], metadata.storage_identifier),
            *(metadata.compression_mode.lower(), metadata.custom_data, counts),
        )


def _path(uri: str) -> Path:
    return Path(uri.removeprefix("file://")) / METADATA


def _entry(file: FileInformation) -> FileEntry:
    start = file.starting_time.nanoseconds
    count = Counter({"": file.message_count})
    return FileEntry(file.path, start, start + file.duration.nanoseconds, count)


def _topic(topic: TopicMetadata) -> TopicInfo:
    offers = tuple(map(qos_of, topic.profiles()))
    parts = topic.type_description_hash, offers, topic.serialization_format
    return TopicInfo(topic.name, topic.type, "", *parts)
