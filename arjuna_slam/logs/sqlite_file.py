"""SQLite recordings of rosbag2 (`.db3`), also those whose recorder or disk came to a sudden end.

Rows are read in the order in which they were written and without the index, up to the first page
that is missing. Files are never changed.

Source: the schema of rosbag2_storage_sqlite3, versions 1 to 4.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

_TABLES = "SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0"
_TOPICS = "SELECT name, type, serialization_format FROM topics"
_DEFINITIONS = (
    "SELECT topic_type, encoded_message_definition FROM message_definitions "
    "WHERE encoding = 'ros2msg'"
)
_MESSAGES = (
    "SELECT id, topic_id, data FROM messages "
    "WHERE typeof(data) = 'blob' AND typeof(id) = 'integer' ORDER BY id"
)


class SqliteFile:
    """A file of rosbag2.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def channels(self) -> dict[str, tuple[str, str, str]]:
        """Return type, encoding and definition ("" where there is none) of each topic.

        Raises:
            sqlite3.Error: It is no such file.
        """
        with closing(self._open()) as database:
            defined: dict[str, str] = {}
            if "message_definitions" in _tables(database):
                defined = dict(database.execute(_DEFINITIONS).fetchall())
            return {
                str(name): (str(kind), str(encoding), str(defined.get(kind, "")))
                for name, kind, encoding in database.execute(_TOPICS)
            }

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        """Yield topic, bytes and the share (0..1) of the file that has been read.

        Args:
            topics: The topics.

        Raises:
            sqlite3.Error: It cannot be read any further.
        """
        with closing(self._open()) as database:
            names = dict(database.execute("SELECT id, name FROM topics"))
            last = _last(database)
            for number, topic, data in database.execute(_MESSAGES):
                if names.get(topic) in topics:
                    yield names[topic], data, number / last

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


def _tables(database: sqlite3.Connection) -> set[str]:
    """Return the real tables: a view could be made to run for ever."""
    return {str(name) for (name,) in database.execute(_TABLES)}


def _last(database: sqlite3.Connection) -> float:
    """Return the number of the last message; infinity where it is missing."""
    try:
        return float(database.execute("SELECT max(id) FROM messages").fetchone()[0] or 1)
    except (sqlite3.Error, ValueError):
        return float("inf")
