"""SQLite files of rosbag2: read, and written."""

from __future__ import annotations

import os
import sqlite3
import sys
from array import array
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.bags import topic as topics
from arjuna_core.bags.file_writer import FileWriter, open_new
from arjuna_core.bags.metadata import BagFile
from arjuna_core.bags.topic import MESSAGE_MAX, BagMessage, TopicInfo
from arjuna_core.files.input_file import open_file

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
    "AND length(data) <= ? "
    "AND typeof(id) || typeof(topic_id) || typeof(timestamp) = 'integerintegerinteger' ORDER BY id"
)
_COMPUTED = (
    "SELECT 1 FROM sqlite_schema AS t, pragma_table_xinfo(t.name) AS c "
    "WHERE t.name IN ('topics', 'messages', 'message_definitions') AND c.hidden > 0"
)
_BESIDE = ("-wal", "-shm", "-journal")
_DATA = "SELECT data FROM messages WHERE id = ?"


class SqliteFile(BagFile):
    """The topics and messages of a `.db3` file."""

    KIND = "db3"
    DAMAGE = (sqlite3.Error,)

    def _take_index(self) -> str:
        with closing(self._open()) as database:
            self._topics = _topics(database)
            found, damage = _index(database)
        self.topics = {each.name: each for each in self._topics.values()}
        self._index = found[np.argsort(found[:, 2], kind="stable")]
        for _, number, time in self._index.tolist():
            if number in self._topics:
                self.entry.count(self._topics[number].name, time)
        return damage

    def _messages(self, takes: Callable[[str], bool], start: int) -> Iterator[BagMessage]:
        wanted = {number: each for number, each in self._topics.items() if takes(each.name)}
        with closing(self._open()) as database:
            for count, (key, number, time) in enumerate(self._index.tolist(), 1):
                self.share = count / len(self._index)
                if time >= start and number in wanted:
                    yield BagMessage(wanted[number], time, _data(database, key))

    def _open(self) -> sqlite3.Connection:
        """Open the file, and the log of what was written last where it lies beside it."""
        wal, *others = (self.path.with_name(self.path.name + end) for end in _BESIDE)
        for file in (self.path, *(each for each in (wal, *others) if os.path.lexists(each))):
            open_file(file).close()  # SQLite opens it again, once it is known to be a file
        mode = "mode=ro" if wal.exists() else "immutable=1"
        database = sqlite3.connect(f"{self.path.absolute().as_uri()}?{mode}", uri=True)
        if sys.version_info >= (3, 11):
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MESSAGE_MAX)
        try:
            database.execute("PRAGMA writable_schema = ON")  # else no file with pages missing opens
            if missing := {"topics", "messages"} - _tables(database):
                raise sqlite3.DatabaseError(f"no table {' or '.join(sorted(missing))}")
            if database.execute(_COMPUTED).fetchone():  # by expressions that could run for ever
                raise sqlite3.DatabaseError("a table has columns that are computed")
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


def _topics(database: sqlite3.Connection) -> dict[int, TopicInfo]:
    known = {str(row[1]) for row in database.execute("PRAGMA table_info(topics)")}
    wanted = ", ".join(name if name in known else "''" for name in _COLUMNS)
    defined: dict[str, str] = {}
    if "message_definitions" in _tables(database):
        defined = dict(database.execute(_DEFINITIONS).fetchall())
    found = {}
    for number, *row in database.execute(f"SELECT id, {wanted} FROM topics"):  # noqa: S608
        name, kind, encoding, qos, type_hash = map(str, row)
        definition = str(defined.get(kind, ""))
        found[number] = TopicInfo(name, kind, definition, type_hash, topics.parse(qos), encoding)
    return found


def _index(database: sqlite3.Connection) -> tuple[np.ndarray, str]:
    """Return number, topic and time [ns] of each message, (n, 3) int64, and what ended it."""
    rows, damage = array("q"), ""
    try:
        for row in database.execute(_INDEX, (MESSAGE_MAX,)):
            rows.extend(row)
    except sqlite3.Error as error:
        damage = str(error)
    return np.array(rows, dtype=np.int64).reshape(-1, 3), damage


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
        open_new(path).close()
        self._database = sqlite3.connect(path, check_same_thread=False)
        resilient = preset == "resilient"
        pragmas = [
            f"journal_mode={'WAL' if resilient else 'MEMORY'}",
            f"synchronous={'NORMAL' if resilient else 'OFF'}",
            *((settings or {}).get("write") or {}).get("pragmas", []),
        ]
        script = "".join(f"PRAGMA {each};" for each in pragmas) + _SCHEMA
        self._guard(lambda: self._database.executescript(script))
        self._types: set[str] = set()

    @property
    def size(self) -> int:
        """Bytes in the file so far, without what waits in memory."""
        (pages,) = self._database.execute("PRAGMA page_count").fetchone()
        (size,) = self._database.execute("PRAGMA page_size").fetchone()
        return int(pages) * int(size)

    def _register(self, topic: TopicInfo) -> int:
        described = (topic.type_name, topic.encoding, topics.dump(topic.offers), topic.type_hash)
        cursor = self._database.execute(
            "INSERT INTO topics VALUES (NULL, ?, ?, ?, ?, ?)", (topic.name, *described)
        )
        if topic.type_name not in self._types:
            self._types.add(topic.type_name)
            defined = (topic.type_name, topic.definition, topic.type_hash)
            self._database.execute(
                "INSERT INTO message_definitions VALUES (NULL, ?, 'ros2msg', ?, ?)", defined
            )
        return int(cursor.lastrowid or 0)

    def _append(self, topic: int, count: int, time: int, data: bytes, published: int) -> None:
        self._database.execute("INSERT INTO messages VALUES (NULL, ?, ?, ?)", (topic, time, data))

    def flush(self) -> None:
        """Hand everything to the operating system."""
        self._guard(self._database.commit)

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """End the file."""
        self.flush()
        self._guard(self._database.close)
