"""One file of a recording being written, an mcap above all."""

from __future__ import annotations

import sqlite3
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO, ClassVar

from mcap.writer import CompressionType, IndexType, Writer

from arjuna_core.bags import topic as topics
from arjuna_core.bags.mcap_file import LOSS_RECORD
from arjuna_core.bags.metadata import FileEntry
from arjuna_core.bags.topic import ROS1, TopicInfo
from arjuna_core.errors import ArjunaError, nearest


class RecordingError(ArjunaError):
    """A recording cannot be written."""


class FileWriter(ABC):
    """One file that is being written.

    Raises:
        RecordingError: The file exists or cannot be written, or a setting is not known.
    """

    SUFFIX: ClassVar[str]
    PRESETS: ClassVar[tuple[str, ...]]
    LEAST_SPLIT: ClassVar[int]
    """Bytes below which rosbag2 refuses to split files of this kind."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entry = FileEntry(path.name)
        self._topics: dict[str, int] = {}

    @property
    @abstractmethod
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""

    def add_topic(self, topic: TopicInfo) -> int:
        """Return the number of a topic within the file; it is in it even without messages."""
        if topic.name not in self._topics:
            self._topics[topic.name] = self._guard(lambda: self._register(topic))
        return self._topics[topic.name]

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message.

        Args:
            time: When it was received [ns].
            published: When it was published [ns].

        Raises:
            RecordingError: The disk refuses.
        """
        number, count = self.add_topic(topic), self.entry.counts[topic.name]
        self._guard(lambda: self._append(number, count, time, data, published))
        self.entry.count(topic.name, time)

    @abstractmethod
    def _register(self, topic: TopicInfo) -> int:
        """Write a new topic; return its number."""

    @abstractmethod
    def _append(self, topic: int, count: int, time: int, data: bytes, published: int) -> None:
        """Write a message, which so many of its topic's were written before."""

    @abstractmethod
    def flush(self) -> None:
        """Hand everything to the operating system: what it has outlives this process."""

    @abstractmethod
    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Write the index, and in mcap files how many messages of a topic never arrived; end it."""

    def _guard(self, write: Callable[[], Any]) -> Any:
        try:
            return write()
        except (OSError, sqlite3.Error) as error:
            reason = getattr(error, "strerror", None) or error
            raise RecordingError(f"{self.path} cannot be written: {reason}") from error


_COMPRESSION = {
    "None": CompressionType.NONE,
    "Lz4": CompressionType.LZ4,
    "Zstd": CompressionType.ZSTD,
}
_OPTIONS: dict[str, Callable[[Any], dict[str, Any]]] = {
    "noChunkCRC": lambda value: {"enable_crcs": not value},
    "enableDataCRC": lambda value: {"enable_data_crcs": bool(value)},
    "noChunking": lambda value: {"use_chunking": not value},
    "noMessageIndex": lambda value: {"index_types": IndexType.CHUNK} if value else {},
    "noSummary": lambda value: {"index_types": IndexType.NONE} if value else {},
    "chunkSize": lambda value: {"chunk_size": int(value)},
    "compression": lambda value: {"compression": _COMPRESSION[value]},
    "noRepeatedSchemas": lambda value: {"repeat_schemas": not value},
    "noRepeatedChannels": lambda value: {"repeat_channels": not value},
    "noStatistics": lambda value: {"use_statistics": not value},
    "noSummaryOffsets": lambda value: {"use_summary_offsets": not value},
    **dict.fromkeys(
        (
            *("noSummaryCRC", "noAttachmentCRC", "compressionLevel", "forceCompression"),
            *("noMetadataIndex", "noChunkIndex"),
        ),
        lambda value: {},
    ),
}
"""What rosbag2_storage_mcap's settings are to the writer; the last ones it has not."""
_PRESETS: dict[str, dict[str, Any]] = {
    "none": {},
    "fastwrite": {"noChunking": True, "noSummaryCRC": True},
    "zstd_fast": {"compression": "Zstd", "compressionLevel": "Fastest", "noChunkCRC": True},
    "zstd_small": {
        "compression": "Zstd",
        "compressionLevel": "Slowest",
        "chunkSize": 4 * 1024 * 1024,
    },
}  # rosbag2_storage_mcap's README


class McapWriter(FileWriter):
    """One mcap file that is being written.

    Args:
        preset: A preset of rosbag2_storage_mcap.
        settings: Its settings, which come before the preset's.
    """

    SUFFIX = ".mcap"
    PRESETS = tuple(_PRESETS)
    LEAST_SPLIT = 1024

    def __init__(
        self,
        path: Path,
        preset: str = "none",
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(path)
        options: dict[str, Any] = {"chunk_size": 4 * 1024 * 1024}
        for name, value in {**_PRESETS[preset], **(settings or {})}.items():
            try:
                options |= _OPTIONS[name](value)
            except KeyError as error:
                given, valid = (value, _COMPRESSION) if name in _OPTIONS else (name, _OPTIONS)
                raise RecordingError(
                    f"'{given}' is no setting of mcap; {nearest(str(given), valid)}"
                ) from error
        self._file = open_new(path)
        self._writer = Writer(self._file, **options)
        self._guard(lambda: self._writer.start(profile="ros2", library="arjuna"))
        self.flush()  # the file is an mcap from its first moment on
        self._schemas: dict[str, int] = {}

    @property
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""
        return self._file.tell()

    def _register(self, topic: TopicInfo) -> int:
        schema = self._schemas.get(topic.type_name)
        if schema is None:
            definition = topic.definition.encode()
            syntax = "ros1msg" if topic.encoding == ROS1 else "ros2msg"
            schema = self._writer.register_schema(topic.type_name, syntax, definition)
            self._schemas[topic.type_name] = schema
        metadata = {
            "offered_qos_profiles": topics.dump(topic.offers),
            "topic_type_hash": topic.type_hash,
        }
        return self._writer.register_channel(topic.name, topic.encoding, schema, metadata)

    def _append(self, topic: int, count: int, time: int, data: bytes, published: int) -> None:
        self._writer.add_message(topic, time, data, published, count)

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._guard(self._writer.flush)

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Write the index and end the file."""
        if lost is not None:
            counts = {topic: str(count) for topic, count in lost.items()}
            self._guard(self._writer.flush)
            self._guard(lambda: self._writer.add_metadata(LOSS_RECORD, counts))
        self._guard(self._writer.finish)
        self._guard(self._file.close)


def open_new(path: Path) -> BinaryIO:
    """Open a file that must not exist yet, for writing."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("xb")
    except FileExistsError as error:
        raise RecordingError(f"{path} exists already and is not overwritten") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error
