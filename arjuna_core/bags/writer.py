"""Recordings written so that rosbag2 plays them and little is lost if the writer is killed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap.writer import Writer

from arjuna_core.bags import topic as topics
from arjuna_core.bags.mcap_file import LOSS_RECORD
from arjuna_core.bags.metadata import METADATA, FileEntry, metadata_yaml
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import ROS1, TopicInfo
from arjuna_core.errors import ArjunaError
from arjuna_core.files.whole_file import write_atomically


class RecordingError(ArjunaError):
    """A recording cannot be written."""


class McapWriter:
    """One mcap file that is being written.

    Args:
        chunk_size: Bytes that a chunk gathers before it is compressed and written.

    Attributes:
        entry: Name, times and counts so far.

    Raises:
        RecordingError: The file exists or cannot be written.
    """

    def __init__(self, path: Path, chunk_size: int = 4 * 1024 * 1024) -> None:
        self.path = path
        self.entry = FileEntry(path.name)
        self._file = _open_new(path)
        self._writer = Writer(self._file, chunk_size=chunk_size)
        self._guard(lambda: self._writer.start(profile="ros2", library="arjuna"))
        self.flush()  # the file is an mcap from its first moment on
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    @property
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""
        return self._file.tell()

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message.

        Args:
            time: When it was received [ns].
            published: When it was published [ns].

        Raises:
            RecordingError: The disk refuses.
        """
        if topic.name not in self._channels:
            self._channels[topic.name] = self._register(topic)
        self.entry.count(topic.name, time)
        number = self.entry.counts[topic.name] - 1
        channel = self._channels[topic.name]
        self._guard(lambda: self._writer.add_message(channel, time, data, published, number))

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

    def flush(self) -> None:
        """Hand everything to the operating system: what it has outlives this process."""
        self._guard(self._writer.flush)

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Write the index and end the file.

        Args:
            lost: How many messages of a topic never arrived.
        """
        if lost is not None:
            counts = {topic: str(count) for topic, count in lost.items()}
            self._guard(self._writer.flush)
            self._guard(lambda: self._writer.add_metadata(LOSS_RECORD, counts))
        self._guard(self._writer.finish)
        self._guard(self._file.close)

    def _guard(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be written: {error.strerror}") from error


@dataclass(frozen=True)
class SplitLimits:
    """Limits at which a recording continues in a new file.

    Attributes:
        size: Bytes of a file after which; 0 for never.
        duration: Recorded time of a file after which [s]; 0 for never.
    """

    size: int = 0
    duration: float = 0.0


@dataclass
class BagFolder:
    """A rosbag2 folder that is being written: numbered mcap files and metadata.yaml.

    Args:
        path: The folder; an existing one is never written into.
        limits: When to continue in a new file.

    Raises:
        RecordingError: The folder exists or cannot be made.
    """

    path: Path
    limits: SplitLimits = field(default_factory=SplitLimits)

    def __post_init__(self) -> None:
        try:
            self.path.mkdir(parents=True)
        except FileExistsError as error:
            raise RecordingError(f"{self.path} exists already and is not overwritten") from error
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be made: {error.strerror}") from error
        self._topics: dict[str, TopicInfo] = {}
        self.files: list[FileEntry] = []
        self._file = self._next()

    def _next(self) -> McapWriter:
        file = McapWriter(self.path / f"{self.path.resolve().name}_{len(self.files)}.mcap")
        self.files.append(file.entry)
        return file

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message; see `McapWriter.write`."""
        if self._full(time):
            self._file.close()
            self._file = self._next()
        self._topics[topic.name] = topic
        self._file.write(topic, time, data, published)

    def _full(self, time: int) -> bool:
        size, duration = self.limits.size, self.limits.duration
        age = time - self._file.entry.start
        return bool(self._file.entry.messages) and (
            0 < size <= self._file.size or 0 < duration * 1e9 <= age
        )

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._file.flush()

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """End the last file and write metadata.yaml.

        Args:
            lost: How many messages of a topic never arrived.
        """
        self._file.close(lost)
        text = metadata_yaml(self._topics.values(), self.files)
        try:
            write_atomically(self.path / METADATA, text.encode())
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be written: {error.strerror}") from error


def repair(bag: Bag, folder: Path) -> int:
    """Write what can be read of a recording into a new folder, with index and metadata.

    Args:
        folder: The new folder; it must not exist.

    Returns:
        How many messages there are.

    Raises:
        RecordingError: The folder exists, or the disk refuses.
    """
    copy = BagFolder(folder)
    for message in bag.messages():
        copy.write(message.topic, message.time, message.data, message.time)
    copy.close(dict(bag.lost))
    return sum(file.messages for file in copy.files)


def _open_new(path: Path) -> BinaryIO:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("xb")
    except FileExistsError as error:
        raise RecordingError(f"{path} exists already and is not overwritten") from error
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error
