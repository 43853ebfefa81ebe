"""One file of a recording being written: mcap, or rosbag2's SQLite."""

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

    Attributes:
        entry: Name, times and counts so far.

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

    @property
    @abstractmethod
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""

    @abstractmethod
    def add_topic(self, topic: TopicInfo) -> int:
        """Return the number of a topic within the file; it is in it even without messages."""

    @abstractmethod
    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message.

        Args:
            time: When it was received [ns].
            published: When it was published [ns].

        Raises:
            RecordingError: The disk refuses.
        """

    @abstractmethod
    def flush(self) -> None:
        """Hand everything to the operating system: what it has outlives this process."""

    @abstractmethod
    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Write the index and end the file.

        Args:
            lost: How many messages of a topic never arrived; mcap files keep that.
        """

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
    "noSummaryCRC": lambda value: {},
    "noAttachmentCRC": lambda value: {},
    "enableDataCRC": lambda value: {"enable_data_crcs": bool(value)},
    "noChunking": lambda value: {"use_chunking": not value},
    "noMessageIndex": lambda value: {"index_types": IndexType.CHUNK} if value else {},
    "noSummary": lambda value: {"index_types": IndexType.NONE} if value else {},
    "chunkSize": lambda value: {"chunk_size": int(value)},
    "compression": lambda value: {"compression": _COMPRESSION[value]},
    "compressionLevel": lambda value: {},
    "forceCompression": lambda value: {},
    "noRepeatedSchemas": lambda value: {"repeat_schemas": not value},
    "noRepeatedChannels": lambda value: {"repeat_channels": not value},
    "noMetadataIndex": lambda value: {},
    "noChunkIndex": lambda value: {},
    "noStatistics": lambda value: {"use_statistics": not value},
    "noSummaryOffsets": lambda value: {"use_summary_offsets": not value},
}
"""What rosbag2_storage_mcap's settings are to the writer; levels and some sums it has not."""
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
        chunk_size: Bytes that a chunk gathers before it is compressed and written.
        preset: A preset of rosbag2_storage_mcap.
        settings: Its settings, which come before the preset's.
    """

    SUFFIX = ".mcap"
    PRESETS = tuple(_PRESETS)
    LEAST_SPLIT = 1024

    def __init__(
        self,
        path: Path,
        chunk_size: int = 4 * 1024 * 1024,
        preset: str = "none",
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(path)
        options: dict[str, Any] = {"chunk_size": chunk_size}
        for name, value in {**_PRESETS[preset], **(settings or {})}.items():
            try:
                options |= _OPTIONS[name](value)
            except KeyError as error:
                given, valid = (value, _COMPRESSION) if name in _OPTIONS else (name, _OPTIONS)
                raise RecordingError(
                    f"'{given}' is no setting of mcap; {nearest(str(given), valid)}"
                ) from error
        self._file = _open_new(path)
        self._writer = Writer(self._file, **options)
        self._guard(lambda: self._writer.start(profile="ros2", library="arjuna"))
        self.flush()  # the file is an mcap from its first moment on
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    @property
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""
        return self._file.tell()

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message; see FileWriter."""
        channel = self.add_topic(topic)
        self.entry.count(topic.name, time)
        number = self.entry.counts[topic.name] - 1
        self._guard(lambda: self._writer.add_message(channel, time, data, published, number))

    def add_topic(self, topic: TopicInfo) -> int:
        """Return the topic's channel."""
        if topic.name in self._channels:
            return self._channels[topic.name]
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
        channel = self._writer.register_channel(topic.name, topic.encoding, schema, metadata)
        self._channels[topic.name] = channel
        return channel

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


_SCHEMA = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL,
  metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,
  encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
  timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (4, 'jazzy');
"""  # rosbag2_storage_sqlite3's version 4


class SqliteWriter(FileWriter):
    """One `.db3` file that is being written.

    Args:
        preset: `resilient` writes through to the disk, so that a loss of power harms no file.
        settings: rosbag2_storage_sqlite3's: `write: {pragmas: [...]}`.
    """

    SUFFIX = ".db3"
    PRESETS = ("none", "resilient")
    LEAST_SPLIT = 86016

    def __init__(
        self, path: Path, preset: str = "none", settings: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(path)
        _open_new(path).close()
        self._database = sqlite3.connect(path, check_same_thread=False)
        resilient = preset == "resilient"
        pragmas = [
            f"journal_mode={'WAL' if resilient else 'MEMORY'}",
            f"synchronous={'NORMAL' if resilient else 'OFF'}",
            *((settings or {}).get("write") or {}).get("pragmas", []),
        ]
        script = "".join(f"PRAGMA {each};" for each in pragmas) + _SCHEMA
        self._guard(lambda: self._database.executescript(script))
        self._topics: dict[str, int] = {}
        self._types: set[str] = set()

    @property
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""
        (pages,) = self._database.execute("PRAGMA page_count").fetchone()
        (size,) = self._database.execute("PRAGMA page_size").fetchone()
        return int(pages) * int(size)

    def add_topic(self, topic: TopicInfo) -> int:
        """Return the topic's row."""
        if topic.name in self._topics:
            return self._topics[topic.name]
        described = (topic.type_name, topic.encoding, topics.dump(topic.offers), topic.type_hash)
        cursor = self._guard(
            lambda: self._database.execute(
                "INSERT INTO topics VALUES (NULL, ?, ?, ?, ?, ?)", (topic.name, *described)
            )
        )
        if topic.type_name not in self._types:
            self._types.add(topic.type_name)
            defined = (topic.type_name, topic.definition, topic.type_hash)
            self._guard(
                lambda: self._database.execute(
                    "INSERT INTO message_definitions VALUES (NULL, ?, 'ros2msg', ?, ?)", defined
                )
            )
        self._topics[topic.name] = int(cursor.lastrowid)
        return self._topics[topic.name]

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message; see FileWriter."""
        number = self.add_topic(topic)
        self.entry.count(topic.name, time)
        self._guard(
            lambda: self._database.execute(
                "INSERT INTO messages VALUES (NULL, ?, ?, ?)", (number, time, data)
            )
        )

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._guard(self._database.commit)

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """End the file."""
        self.flush()
        self._guard(self._database.close)


STORAGES: dict[str, type[McapWriter] | type[SqliteWriter]] = {
    "mcap": McapWriter,
    "sqlite3": SqliteWriter,
}
"""rosbag2's storages by their identifiers."""


def _open_new(path: Path) -> BinaryIO:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("xb")
    except FileExistsError as error:
        raise RecordingError(f"{path} exists already and is not overwritten") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error
