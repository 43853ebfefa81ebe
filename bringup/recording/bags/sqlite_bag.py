"""One sqlite3 file (.db3) of a recording, as far as it goes."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from arjuna_core.files.rosbag2_sqlite import SqliteFile, SqliteTopic
from bringup.recording.bags import topic as topics
from bringup.recording.bags.metadata import FileEntry
from bringup.recording.bags.topic import BagMessage, TopicInfo


class SqliteBag:
    """What a .db3 file holds, with the attributes of `McapBag`.

    Args:
        path: The file.

    Raises:
        InputFileError: It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entry = FileEntry(path.name)
        self.lost: Counter[str] = Counter()
        self.problems: list[str] = []
        self._file = SqliteFile(path)
        self._topics = {number: _topic(each) for number, each in self._file.topics.items()}
        self.topics = {each.name: each for each in self._topics.values()}
        for _, number, time in self._file.index.tolist():
            if number in self._topics:
                self.entry.count(self._topics[number].name, time)
        self._note(self._file.damage)

    @property
    def share(self) -> float:
        """Share (0..1) that has been read."""
        return self._file.share

    def messages(
        self, takes: Callable[[str], bool] = lambda topic: True, start: int = 0
    ) -> Iterator[BagMessage]:
        """Yield its messages in the order of their time; see `McapBag.messages`."""
        wanted = {number for number, each in self._topics.items() if takes(each.name)}
        try:
            for number, time, data in self._file.messages(wanted, start):
                yield BagMessage(self._topics[number], time, data)
        except sqlite3.Error as error:
            self._note(str(error))

    def _note(self, damage: str) -> None:
        text = f"{self.path.name}: damaged or cut short ({damage}); read up to there"
        if damage and text not in self.problems:
            self.problems.append(text)


def _topic(topic: SqliteTopic) -> TopicInfo:
    offers = topics.parse(topic.qos)
    known = topic.name, topic.kind, topic.definition, topic.type_hash
    return TopicInfo(*known, offers, topic.encoding)
