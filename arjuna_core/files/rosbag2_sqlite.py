"""SQLite recordings of rosbag2 (`.db3`), also those whose recorder or disk came to a sudden end.

Rows are found in the order in which they were written and without the database's index, up to the
first page that is missing. Files are never changed.

Source: the schema of rosbag2_storage_sqlite3, versions 1 to 4.
"""

from __future__ import annotations

import sqlite3
from array import array
from collections.abc import Container, Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np

from arjuna_core.errors import InputFileError

_TABLES = "SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0"
_COLUMNS = (
    *("name", "type", "serialization_format"),
    *("offered_qos_profiles", "type_description_hash"),
)
_DEFINITIONS = (
    "SELECT topic_type, encoded_message_definition FROM message_definitions "
    "WHERE encoding = 'ros2msg'"
)
_INDEX = (
    "SELECT id, topic_id, timestamp FROM messages WHERE typeof(data) = 'blob' "
    "AND typeof(id) || typeof(topic_id) || typeof(timestamp) = 'integerintegerinteger' ORDER BY id"
)
_DATA = "SELECT data FROM messages WHERE id = ?"


class SqliteTopic(NamedTuple):
    """What a file says of a topic; texts are empty where it says nothing."""

    name: str
    kind: str
    encoding: str
    qos: str
    type_hash: str
    definition: str


class SqliteFile:
    """A `.db3` file.

    Args:
        path: The file.

    Attributes:
        topics: Its topics by number.
        index: Number, topic and time [ns] of each message in the order of time, (n, 3) int64.
        damage: What ended the search for messages, empty where nothing did.
        share: Share (0..1) of the messages that has been read.

    Raises:
        InputFileError: It is no such file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.share = 0.0
        try:
            with closing(self._open()) as database:
                self.topics = _topics(database)
                found, self.damage = _index(database)
        except sqlite3.Error as error:
            raise InputFileError(path, f"is no db3 recording: {error}") from error
        self.index = found[np.argsort(found[:, 2], kind="stable")]

    def messages(self, topics: Container[int], start: int = 0) -> Iterator[tuple[int, int, bytes]]:
        """Yield the topic's number, time [ns] and bytes of messages in the order of their time.

        Args:
            topics: Numbers of the topics that are wanted.
            start: From when on [ns].

        Raises:
            sqlite3.Error: The file is damaged; what could be read has been yielded.
        """
        with closing(self._open()) as database:
            for count, (number, topic, time) in enumerate(self.index.tolist()):
                self.share = count / len(self.index)
                if time >= start and topic in topics:
                    yield topic, time, _data(database, number)
        if self.damage:
            raise sqlite3.DatabaseError(self.damage)
        self.share = 1.0

    def _open(self) -> sqlite3.Connection:
        """Open the file, and the log of what was written last where it lies beside it."""
        log = self._path.with_name(self._path.name + "-wal")
        mode = "mode=ro" if log.exists() else "immutable=1"
        database = sqlite3.connect(f"{self._path.absolute().as_uri()}?{mode}", uri=True)
        try:
            database.execute("PRAGMA writable_schema = ON")  # else no file with pages missing opens
            if missing := {"topics", "messages"} - _tables(database):
                raise sqlite3.DatabaseError(f"no table {' or '.join(sorted(missing))}")
        except sqlite3.Error:
            database.close()
            raise
        return database


def _data(database: sqlite3.Connection, number: int) -> bytes:
    row = database.execute(_DATA, (number,)).fetchone()
    if row is None:
        raise sqlite3.DatabaseError(f"message {number} is not where it should be")
    return bytes(row[0])


def _tables(database: sqlite3.Connection) -> set[str]:
    """Return the real tables: a view could be made to run for ever."""
    return {str(name) for (name,) in database.execute(_TABLES)}


def _topics(database: sqlite3.Connection) -> dict[int, SqliteTopic]:
    known = {str(row[1]) for row in database.execute("PRAGMA table_info(topics)")}
    wanted = ", ".join(name if name in known else "''" for name in _COLUMNS)
    defined: dict[str, str] = {}
    if "message_definitions" in _tables(database):
        defined = dict(database.execute(_DEFINITIONS).fetchall())
    return {
        number: SqliteTopic(*map(str, (*row, defined.get(row[1], ""))))
        for number, *row in database.execute(f"SELECT id, {wanted} FROM topics")  # noqa: S608
    }


def _index(database: sqlite3.Connection) -> tuple[np.ndarray, str]:
    """Return number, topic and time of each message, and what ended the search."""
    rows, damage = array("q"), ""
    try:
        for row in database.execute(_INDEX):
            rows.extend(row)
    except sqlite3.Error as error:
        damage = str(error)
    return np.array(rows, dtype=np.int64).reshape(-1, 3), damage
