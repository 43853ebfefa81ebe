"""One sqlite3 file (.db3) of a recording, read by the rosbags library."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import apsw
from rosbags.interfaces import ConnectionExtRosbag2
from rosbags.rosbag2 import Reader, ReaderError

from arjuna_core.errors import InputFileError
from bringup.recording.bags.metadata import FileEntry
from bringup.recording.bags.topic import BagMessage, TopicInfo, TopicQos

_DAMAGE = (ReaderError, apsw.Error, OSError, ValueError, TypeError, AssertionError)
"""What rosbags raises where a file is damaged."""


def _why(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


class SqliteBag:
    """What a .db3 file, or a whole folder of them that may be compressed, holds.

    It has the attributes of `McapBag`.

    Args:
        path: The file or folder.

    Raises:
        InputFileError: It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entry = FileEntry(path.name)
        self.lost: Counter[str] = Counter()
        self.problems: list[str] = []
        self.share = 0.0
        with self._open() as reader:
            self.topics = {each.topic: _topic(each) for each in reader.connections}
            for each in reader.connections:
                self.entry.counts[each.topic] += each.msgcount
            if reader.message_count:  # rosbags ends one nanosecond after the last message
                self.entry.start, self.entry.end = reader.start_time, reader.end_time - 1

    def _open(self) -> closing[Reader]:
        try:
            reader = Reader(self.path)
            reader.open()
        except _DAMAGE as error:
            raise InputFileError(self.path, f"is no recording of rosbag2: {_why(error)}") from error
        return closing(reader)

    def messages(
        self, takes: Callable[[str], bool] = lambda topic: True, start: int = 0
    ) -> Iterator[BagMessage]:
        """Yield its messages in the order of their time; see `McapBag.messages`."""
        with self._open() as reader:
            wanted = [each for each in reader.connections if takes(each.topic)]
            length = max(self.entry.end - self.entry.start, 1)
            if not wanted:  # none given would mean all
                return
            try:
                for each, time, data in reader.messages(wanted, start=start):
                    self.share = (time - self.entry.start) / length
                    yield BagMessage(self.topics[each.topic], time, bytes(data))
            except _DAMAGE as error:
                note = f"{self.path.name}: damaged ({_why(error)}); read up to there"
                if note not in self.problems:
                    self.problems.append(note)


def _topic(connection: Any) -> TopicInfo:
    extra = connection.ext
    assert isinstance(extra, ConnectionExtRosbag2)
    offers = tuple(
        TopicQos(
            each.reliability.name != "BEST_EFFORT",
            each.durability.name == "TRANSIENT_LOCAL",
            max(each.depth, 0),
        )
        for each in extra.offered_qos_profiles
    )
    return TopicInfo(
        connection.topic,
        connection.msgtype,
        connection.msgdef.data,
        connection.digest,
        offers,
        extra.serialization_format,
    )
