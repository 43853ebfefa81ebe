"""Recordings read: an mcap or .db3 file, a rosbag2 folder of either, or a bag of ROS 1."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import zstandard

from arjuna_core.bags.mcap_file import McapFile
from arjuna_core.bags.metadata import BagFile, FileEntry, read_metadata
from arjuna_core.bags.ros1_file import Ros1File
from arjuna_core.bags.sqlite_file import SqliteFile
from arjuna_core.bags.topic import MESSAGE_MAX, BagMessage, TopicInfo
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import check_growth, open_file

PACKED = ".zstd"
"""The suffix of compressed files: rosbag2 has no other compression."""

_KINDS: dict[str, tuple[str, type[BagFile]]] = {
    ".mcap": ("mcap", McapFile),
    ".db3": ("sqlite3", SqliteFile),
    ".bag": ("rosbag1", Ros1File),
}
SUFFIXES = tuple(_KINDS)
"""Suffixes of files that can be read."""

_VALID = f"valid: a file of {', '.join(SUFFIXES)}, or a folder of such files"


class Bag:
    """A recording.

    Args:
        indexed: Whether its metadata.yaml is read, if it has one.

    Attributes:
        storage: `mcap`, `sqlite3` or `rosbag1`.
        topics: Its topics by name.
        lost: How many messages of a topic never reached the recorder.

    Raises:
        InputFileError: It is no recording, or one of its files is missing or cannot be unpacked.
    """

    def __init__(self, path: Path, indexed: bool = True) -> None:
        self.path = path
        metadata = read_metadata(path) if indexed else None
        self.distribution = str((metadata or {}).get("ros_distro") or "unknown")
        self._messages_packed = (
            metadata is not None and str(metadata.get("compression_mode", "")).lower() == "message"
        )
        names = None if metadata is None else metadata["relative_file_paths"]
        self._folder: TemporaryDirectory[str] | None = None
        found = _files(path, names)
        files = [self._unpacked(file) for file in found]
        self.storage = _KINDS[files[0].suffix][0]
        self._files = [_KINDS[file.suffix][1](file) for file in files]
        for file, each in zip(found, self._files, strict=True):
            each.entry.name = file.name
        self.topics: dict[str, TopicInfo] = {}
        self.lost: Counter[str] = Counter()
        for each in self._files:
            self.topics.update(each.topics)
            self.lost.update(each.lost)
        self.files: list[FileEntry] = [each.entry for each in self._files]
        self._reading = 0
        self._problems = []
        if path.is_dir() and metadata is None:
            missing = "has no metadata.yaml, as if the recorder was killed"
            self._problems.append(f"{path.name}: {missing}")

    def _unpacked(self, file: Path) -> Path:
        """Return a file, or its uncompressed copy, which exists as long as this object."""
        if file.suffix != PACKED:
            return file
        self._folder = self._folder or TemporaryDirectory(prefix="recording_")
        copy = Path(self._folder.name, file.stem)
        try:
            with open_file(file) as source, copy.open("wb") as target:
                for part in zstandard.ZstdDecompressor().read_to_iter(source):
                    target.write(part)
                    check_growth(file, source.tell(), target.tell(), 1 << 28)
                    # Unpacking leaves 1 GiB of the disk free.
                    if shutil.disk_usage(copy).free < 1 << 30:
                        raise InputFileError(file, "cannot be unpacked: the disk is full")
        except (zstandard.ZstdError, OSError) as error:
            raise InputFileError(file, f"cannot be unpacked: {error}") from error
        return copy

    @property
    def problems(self) -> list[str]:
        """Damages found so far."""
        return [*self._problems, *(text for each in self._files for text in each.problems)]

    @property
    def counts(self) -> Counter[str]:
        """Number of its messages by topic."""
        return sum((file.counts for file in self.files), Counter[str]())

    @property
    def start(self) -> int:
        """When the first message was received [ns]."""
        return min((file.start for file in self.files if file.counts), default=0)

    @property
    def end(self) -> int:
        """When the last message was received [ns]."""
        return max((file.end for file in self.files if file.counts), default=0)

    @property
    def share(self) -> float:
        """Share (0..1) that has been read."""
        return (self._reading + self._files[self._reading].share) / len(self._files)

    @property
    def current_file(self) -> Path:
        """The file that is being read."""
        return self.path / self.files[self._reading].name if self.path.is_dir() else self.path

    @property
    def size(self) -> int:
        """Size of all files [bytes]."""
        return sum(each.path.stat().st_size for each in self._files)

    def messages(
        self, takes: Callable[[str], bool] = lambda topic: True, start: int = 0
    ) -> Iterator[BagMessage]:
        """Yield the messages of wanted topics from a time [ns] on, in their order, file by file."""
        for number, file in enumerate(self._files):
            self._reading = number
            if file.entry.end < start:
                continue
            for message in file.messages(takes, start):
                try:
                    data = self._content(message.data)
                except ValueError as error:
                    problem = f"{file.path.name}: {message.topic.name}: {error}"
                    if problem not in self._problems:
                        self._problems.append(problem)
                else:
                    yield message._replace(data=data)

    def _content(self, data: bytes) -> bytes:
        """Return a message's bytes, unpacked where each is compressed by itself.

        Raises:
            ValueError: They are damaged, or would be more than any message's.
        """
        if not self._messages_packed:
            return data
        try:
            if zstandard.frame_content_size(data) > MESSAGE_MAX:
                raise ValueError(f"a message of more than {MESSAGE_MAX} bytes")
            return zstandard.decompress(data, max_output_size=MESSAGE_MAX)
        except zstandard.ZstdError as error:
            raise ValueError(f"a message cannot be unpacked: {error}") from error


def _files(path: Path, names: list[str] | None) -> list[Path]:
    """Return a recording's files in the order of their times."""
    if not os.path.lexists(path):
        raise InputFileError(path, f"does not exist; {_VALID}")
    if names is not None:
        files = [path / name for name in names]
    elif path.is_dir():
        files = sorted((file for file in path.iterdir() if _suffix(file) in _KINDS), key=_number)
    else:
        files = [path]
    if not files:
        raise InputFileError(path, f"holds no recording; {_VALID}")
    for file in files:
        if _suffix(file) not in _KINDS or not file.is_file():
            raise InputFileError(file, f"is no recording; {_VALID}")
    return files


def _suffix(file: Path) -> str:
    return Path(file.name.removesuffix(PACKED)).suffix


def _number(file: Path) -> tuple[int, str]:
    """Return a key that sorts the files of a recording: `run_10.mcap` after `run_9.mcap`."""
    digits = file.name.split(".")[0].rpartition("_")[2]
    return (int(digits) if digits.isdecimal() else 0), file.name
