"""Claims: .db3 files are read as far as they go, in the order of time, and never changed."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import dump
from arjuna_core.bags.writer import repair
from arjuna_core.errors import InputFileError
from tests.core.bags.recordings import LATCHED, MS, times, write_words


def _sqlite(path: Path) -> None:
    with sqlite3.connect(path) as database:
        database.execute(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
            "serialization_format TEXT, offered_qos_profiles TEXT)"
        )
        database.execute(
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
            "timestamp INTEGER, data BLOB)"
        )
        row = (1, LATCHED.name, LATCHED.type_name, "cdr", dump(LATCHED.offers))
        database.execute("INSERT INTO topics VALUES(?, ?, ?, ?, ?)", row)
        for number in range(3):
            row = (number, 1, number * MS, b"\0\1\0\0")  # type: ignore[assignment]
            database.execute("INSERT INTO messages VALUES(?, ?, ?, ?)", row)
    database.close()


def test_sqlite_recordings_are_read_alone_and_without_metadata(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    _sqlite(tmp_path / "bag" / "bag_0.db3")
    for path in (tmp_path / "bag" / "bag_0.db3", tmp_path / "bag"):
        bag = Bag(path)
        assert (bag.storage, bag.start, bag.end) == ("sqlite3", 0, 2 * MS)
        assert bag.topics["/word"].offers == LATCHED.offers
        assert times(bag) == [0, 1, 2]


def test_a_cut_database_is_read_noted_and_repaired(tmp_path: Path) -> None:
    path = write_words(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])
    bag = Bag(path)
    found = times(bag)
    assert 400 < len(found) < 1900
    assert found == list(range(len(found)))
    assert bag.counts.total() == len(found)
    assert any("damaged or cut short" in line for line in bag.problems)
    assert repair(bag, tmp_path / "mended") == len(found)


def test_messages_of_a_database_come_in_the_order_of_time(tmp_path: Path) -> None:
    path = write_words(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("UPDATE messages SET timestamp = 2000000000 - timestamp")
    database.close()
    assert times(Bag(path)) == list(range(1, 2001))


def test_what_a_killed_recorder_left_in_its_log_is_read_and_nothing_changed(tmp_path: Path) -> None:
    source = write_words(tmp_path / "bag", "SQLITE3", "NONE")
    database = sqlite3.connect(source / "bag.db3")
    database.execute("PRAGMA journal_mode = WAL")
    database.execute("DELETE FROM messages WHERE id > 20")
    database.commit()
    for name in ("bag.db3", "bag.db3-wal"):
        shutil.copy(source / name, tmp_path / name)
    database.close()
    before = (tmp_path / "bag.db3").read_bytes()
    assert times(Bag(tmp_path / "bag.db3")) == list(range(20))
    assert (tmp_path / "bag.db3").read_bytes() == before


def test_an_unfinished_transaction_beside_a_database_does_not_stop_it(tmp_path: Path) -> None:
    path = write_words(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    path.with_name("bag.db3-journal").write_bytes(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7" * 100)
    assert times(Bag(path)) == list(range(2000))


def with_view(path: Path) -> None:
    database = sqlite3.connect(path)
    database.execute("DROP TABLE messages")
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
    database.execute(f"CREATE VIEW messages AS {endless} SELECT i AS id, 1 AS topic_id FROM n")
    database.commit()
    database.close()


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (lambda p: p.write_bytes(b"no recording" * 100), "is no db3 recording: file is"),
        (lambda p: p.write_bytes(b""), "no table messages or topics"),
        (with_view, "no table messages"),
    ],
)
def test_a_file_that_is_no_database_of_messages_is_refused(
    spoil: Callable[[Path], None], problem: str, tmp_path: Path
) -> None:
    path = write_words(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    spoil(path)
    with pytest.raises(InputFileError, match=problem):
        Bag(path)
