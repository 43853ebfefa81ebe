"""Recordings on disk: mcap, rosbag2's SQLite, folders of either and ROS 1 bags, message by message.

rosbags reads the messages and ROS 1 bags, but mcap and SQLite are read as they lie in the file,
so that one that was cut short is read as far as it goes and nothing grows beyond bounds.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

from rosbags.rosbag1 import Reader, ReaderError

from arjuna_core.errors import InputFileError
from arjuna_core.files.rosbag2 import RecordingFiles
from arjuna_core.files.rosbag2_sqlite import SqliteFile
from arjuna_slam.logs.mcap_file import McapFile
from arjuna_slam.logs.mcap_records import DAMAGE
from arjuna_slam.logs.messages import ROS1

_DAMAGE = (*DAMAGE, ReaderError, sqlite3.Error, AssertionError, IndexError, OSError)


class Channel(NamedTuple):
    """What a topic carries: type, encoding and, where the file has it, the type's definition."""

    kind: str
    encoding: str
    definition: str


class _File(Protocol):
    """One file of a recording."""

    def channels(self) -> dict[str, tuple[str, str, str]]:
        """Return type, encoding and definition of each topic."""

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        """Yield topic, bytes and the share (0..1) of the file that has been read."""


class _BagFile:
    """A bag of ROS 1."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def channels(self) -> dict[str, tuple[str, str, str]]:
        with Reader(self._path) as bag:
            return {c.topic: (c.msgtype, ROS1, c.msgdef.data) for c in bag.connections}

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        with Reader(self._path) as bag:
            wanted = [c for c in bag.connections if c.topic in topics]
            if not wanted:  # none given would mean all
                return
            for connection, stamp, data in bag.messages(wanted):
                yield connection.topic, data, (stamp - bag.start_time) / max(bag.duration, 1)


class _SqliteFile:
    """A file of rosbag2's SQLite storage."""

    def __init__(self, path: Path) -> None:
        self._file = SqliteFile(path)

    def channels(self) -> dict[str, tuple[str, str, str]]:
        found = self._file.topics.values()
        return {each.name: (each.kind, each.encoding, each.definition) for each in found}

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        names = {k: each.name for k, each in self._file.topics.items() if each.name in topics}
        for number, _, data in self._file.messages(names):
            yield names[number], data, self._file.share


_KINDS: dict[str, Callable[[Path], _File]] = {
    ".mcap": McapFile,
    ".db3": _SqliteFile,
    ".bag": _BagFile,
}
SUFFIXES = tuple(_KINDS)
"""Suffixes of files that can be read."""


class Storage:
    """The files of one recording.

    Args:
        path: A file, or a rosbag2 folder with such files.

    Attributes:
        progress: Share (0..1) that has been read.
        problems: What was passed over.

    Raises:
        InputFileError: It is no recording.
    """

    def __init__(self, path: Path) -> None:
        self.progress = 0.0
        self.problems: list[str] = []
        self._recording = RecordingFiles(path, SUFFIXES)
        self._files = [(file, _KINDS[file.suffix](file)) for file in self._recording.files]

    def channels(self) -> dict[str, Channel]:
        """Return what each topic carries.

        Raises:
            InputFileError: A file is no recording.
        """
        found: dict[str, Channel] = {}
        for path, file in self._files:
            try:
                found.update({name: Channel(*c) for name, c in file.channels().items()})
            except _DAMAGE as error:
                problem = f"is no {path.suffix[1:]} recording: {_reason(error)}"
                raise InputFileError(path, problem) from error
        return found

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes]]:
        """Yield topic and bytes of each message of some topics, in the order of the files.

        Args:
            topics: The topics.
        """
        self.progress = 0.0
        for number, (path, file) in enumerate(self._files):
            try:
                for topic, data, share in file.messages(topics):
                    self.progress = (number + share) / len(self._files)
                    yield topic, self._recording.message(data)
            except _DAMAGE as error:
                what = f"{path.name}: damaged or cut short ({_reason(error)})"
                note = f"{what}; read as far as it goes"
                if note not in self.problems:
                    self.problems.append(note)


def _reason(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
