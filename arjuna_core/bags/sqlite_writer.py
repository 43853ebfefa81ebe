"""SQLite files of rosbag2 being written."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from arjuna_core.bags import topic as topics
from arjuna_core.bags.file_writer import FileWriter, open_new
from arjuna_core.bags.topic import TopicInfo

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
