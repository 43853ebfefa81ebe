"""Recordings written so that rosbag2 plays them and little is lost if the writer is killed."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import zstandard

from arjuna_core.bags.file_writer import FileWriter, McapWriter, RecordingError
from arjuna_core.bags.metadata import METADATA, FileEntry, metadata_yaml, read_metadata
from arjuna_core.bags.reader import PACKED, Bag
from arjuna_core.bags.sqlite_file import SqliteWriter
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import open_file
from arjuna_core.files.whole_file import write_atomically

STORAGES: dict[str, type[McapWriter] | type[SqliteWriter]] = {
    "mcap": McapWriter,
    "sqlite3": SqliteWriter,
}
"""rosbag2's storages by their identifiers."""


@dataclass(frozen=True)
class SplitLimits:
    """Limits at which a recording continues in a new file.

    Attributes:
        size: Bytes of a file after which; 0 for never.
        duration: Recorded time of a file after which [s]; 0 for never.
    """

    size: int = 0
    duration: float = 0.0


@dataclass(frozen=True)
class BagFormat:
    """The storage of a recording.

    Attributes:
        storage: `mcap` or `sqlite3`.
        settings: The storage's own settings, which come before the preset's.
        compression: What is compressed by zstd: "" nothing, `file` or `message`.
        threads: How many files are compressed at once; 0 for one a core.
        custom: What else metadata.yaml shall hold.
    """

    storage: str = "mcap"
    preset: str = "none"
    settings: Mapping[str, Any] = field(default_factory=dict)
    compression: str = ""
    threads: int = 0
    custom: Mapping[str, str] = field(default_factory=dict)

    def writer(self, path: Path, limits: SplitLimits) -> FileWriter:
        """Return the writer of a new file, whose chunks are smaller than it shall be."""
        settings = dict(self.settings)
        if limits.size and self.storage == "mcap":
            usual = settings.get("chunkSize", 1 << 22)
            settings["chunkSize"] = min(usual, max(limits.size // 4, 1024))
        return STORAGES[self.storage](path, preset=self.preset, settings=settings)


@dataclass
class BagFolder:
    """A rosbag2 folder that is being written: numbered files and metadata.yaml.

    Args:
        path: The folder; an existing one is never written into.
        on_split: Called with the paths of the file that has ended and of the next one.

    Raises:
        RecordingError: The folder exists or cannot be made.
    """

    path: Path
    limits: SplitLimits = field(default_factory=SplitLimits)
    format: BagFormat = field(default_factory=BagFormat)
    on_split: Callable[[Path, Path], None] = lambda closed, opened: None

    def __post_init__(self) -> None:
        try:
            self.path.mkdir(parents=True)
        except FileExistsError as error:
            raise RecordingError(f"{self.path} exists already and is not overwritten") from error
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be made: {error.strerror}") from error
        self._topics: dict[str, TopicInfo] = {}
        self.files: list[FileEntry] = []
        threads = self.format.threads or os.cpu_count()
        self._packers = ThreadPoolExecutor(threads)  # its threads begin with the first file
        self._packing: list[Future[None]] = []
        self._file = self._next()

    def _next(self) -> FileWriter:
        suffix = STORAGES[self.format.storage].SUFFIX
        path = self.path / f"{self.path.resolve().name}_{len(self.files)}{suffix}"
        file = self.format.writer(path, self.limits)
        self.files.append(file.entry)
        for topic in self._topics.values():
            file.add_topic(topic)
        return file

    def add_topic(self, topic: TopicInfo) -> None:
        """Note a topic, which the recording lists even where no message comes."""
        if topic.name not in self._topics:
            self._topics[topic.name] = topic
            self._file.add_topic(topic)

    def write(self, topic: TopicInfo, time: int, data: bytes, published: int) -> None:
        """Add a message; see `FileWriter.write`."""
        if self._full(time):
            self.split()
        self._topics[topic.name] = topic
        if self.format.compression == "message":
            data = zstandard.compress(data)
        self._file.write(topic, time, data, published)

    def _full(self, time: int) -> bool:
        size, duration = self.limits.size, self.limits.duration
        age = time - self._file.entry.start
        return bool(self._file.entry.messages) and (
            0 < size <= self._file.size or 0 < duration * 1e9 <= age
        )

    def split(self) -> None:
        """Continue in a new file."""
        before = self._end_file(None)
        self._file = self._next()
        self.on_split(before, self._file.path)

    def _end_file(self, lost: Mapping[str, int] | None) -> Path:
        """End the file and return its path, which is that of its compressed copy to come."""
        path = self._file.path
        self._file.close(lost)
        if self.format.compression != "file":
            return path
        self._file.entry.name += PACKED
        self._packing.append(self._packers.submit(_pack, path))
        return path.with_name(self._file.entry.name)

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._file.flush()

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """End the last file and write metadata.yaml; of each topic so many messages were `lost`."""
        self._end_file(lost)
        self._packers.shutdown()
        try:
            for each in self._packing:
                each.result()
            _write_metadata(self.path, self._topics.values(), self.files, self.format)
        except OSError as error:
            raise RecordingError(f"{self.path} cannot be written: {error.strerror}") from error


def _pack(path: Path) -> None:
    """Replace a file by a compressed one."""
    with open_file(path) as source, path.with_name(path.name + PACKED).open("xb") as target:
        zstandard.ZstdCompressor().copy_stream(source, target)
    path.unlink()


def _write_metadata(
    folder: Path, topics: Iterable[TopicInfo], files: list[FileEntry], form: BagFormat
) -> None:
    text = metadata_yaml(topics, files, form.storage, form.compression, form.custom)
    write_atomically(folder / METADATA, text.encode())


def reindex(folder: Path) -> Bag:
    """Write the metadata.yaml of a folder again from its files, and return the recording.

    Raises:
        InputFileError: The folder holds no files of a recording.
        RecordingError: The disk refuses.
    """
    bag = Bag(folder, indexed=False)
    compression = "file" if any(file.name.endswith(PACKED) for file in bag.files) else ""
    with contextlib.suppress(InputFileError):  # what is compressed by message, no file says
        before = read_metadata(folder) or {}
        compression = compression or str(before.get("compression_mode", "")).lower()
    form = BagFormat(bag.storage, compression=compression)
    try:
        _write_metadata(folder, bag.topics.values(), bag.files, form)
    except OSError as error:
        raise RecordingError(f"{folder} cannot be written: {error.strerror}") from error
    return bag


def repair(bag: Bag, folder: Path) -> int:
    """Write what can be read of a recording into a new folder, with index and metadata.

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
