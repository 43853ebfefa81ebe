"""Recordings that are written, and sqlite files."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from rosbags.rosbag2 import Reader

from arjuna_core.bags.file_writer import McapWriter, RecordingError
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import dump
from arjuna_core.bags.writer import STORAGES, BagFolder, BagFormat, SplitLimits, reindex, repair
from arjuna_core.errors import InputFileError
from tests.core.bags.recordings import (
    ENTRIES,
    LATCHED,
    MS,
    NUMBER,
    times,
    write_numbers,
    write_ros1,
    write_words,
)

FORMS = [
    *(BagFormat(storage, compression=c) for storage in STORAGES for c in ("", "file", "message")),
    BagFormat("sqlite3", "resilient", threads=1),
    *(BagFormat(preset=preset) for preset in McapWriter.PRESETS),
    BagFormat(settings={"noChunking": True, "compression": "Lz4"}, custom={"robot": "burger"}),
]


@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_is_read_by_rosbags_too(tmp_path: Path, form: BagFormat) -> None:
    write_numbers(tmp_path / "bag", limits=SplitLimits(duration=0.03), form=form).close()
    metadata = tmp_path / "bag" / "metadata.yaml"
    before = yaml.safe_load(metadata.read_text())
    again = reindex(tmp_path / "bag")
    assert (again.storage, again.counts.total()) == (form.storage, 100)
    assert before["rosbag2_bagfile_information"].pop("custom_data", None) == (form.custom or None)
    after = yaml.safe_load(metadata.read_text())
    after["rosbag2_bagfile_information"].pop("custom_data", None)
    assert after == before
    ours = [(m.topic.name, m.time, m.data) for m in Bag(tmp_path / "bag").messages()]
    with Reader(tmp_path / "bag") as reader:
        theirs = [(c.topic, time, data) for c, time, data in reader.messages()]
        kinds = {c.topic: (c.msgtype, c.digest) for c in reader.connections}
    assert ours == theirs
    assert len(ours) == 100
    assert kinds == {
        "/number": ("std_msgs/msg/Int32", "RIHS01_0"),
        "/word": ("std_msgs/msg/String", "RIHS01_1"),
    }


def test_topics_keep_type_definition_and_qos(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    assert Bag(tmp_path / "bag").topics == {"/number": NUMBER, "/word": LATCHED}


def test_metadata_says_what_rosbag2_asks_for(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    text = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())
    found = text["rosbag2_bagfile_information"]
    assert found["storage_identifier"] == "mcap"
    assert found["message_count"] == 100
    assert found["duration"] == {"nanoseconds": 99 * MS}
    assert found["relative_file_paths"] == ["bag_0.mcap"]


@pytest.mark.parametrize("limits", [SplitLimits(size=300), SplitLimits(duration=0.02)])
def test_split_recordings_are_read_as_one(tmp_path: Path, limits: SplitLimits) -> None:
    write_numbers(tmp_path / "bag", limits=limits).close()
    bag = Bag(tmp_path / "bag")
    assert len(bag.files) >= 5
    assert [file.name for file in bag.files[:2]] == ["bag_0.mcap", "bag_1.mcap"]
    for start in range(101):
        found = [message.time // MS for message in bag.messages(start=start * MS)]
        assert found == list(range(start, 100))
    paths = [tmp_path / "bag" / file.name for file in bag.files]
    assert bag.current_file == paths[-1]
    assert bag.share == pytest.approx(1.0, abs=1e-3)
    assert (bag.start, bag.end) == (0, 99 * MS)
    assert bag.size == sum(path.stat().st_size for path in paths)
    metadata = tmp_path / "bag" / "metadata.yaml"
    files = yaml.safe_load(metadata.read_text())["rosbag2_bagfile_information"]["files"]
    starts = [file["starting_time"]["nanoseconds_since_epoch"] for file in files]
    ends = [a + f["duration"]["nanoseconds"] for a, f in zip(starts, files, strict=True)]
    assert starts == [0, *(end + MS for end in ends[:-1])]
    metadata.unlink()
    (tmp_path / "bag" / "notes.txt").write_text("what lies beside them is none of them")
    assert times(Bag(tmp_path / "bag")) == list(range(100))


def test_a_recording_of_nothing_begins_and_ends_at_zero(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag", 0).close()
    bag = Bag(tmp_path / "bag")
    assert (bag.start, bag.end, times(bag)) == (0, 0, [])
    text = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())
    found = text["rosbag2_bagfile_information"]
    assert found["duration"] == {"nanoseconds": 0}
    assert found["starting_time"] == {"nanoseconds_since_epoch": 0}


def test_an_existing_folder_is_never_written_into(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    with pytest.raises(RecordingError, match="exists already and is not overwritten"):
        BagFolder(tmp_path / "bag")


def test_an_abandoned_recording_is_read_to_the_last_flush_and_mended(tmp_path: Path) -> None:
    abandoned = write_numbers(tmp_path / "bag", 95)
    bag = Bag(tmp_path / "bag")
    assert times(bag) == list(range(90))
    assert any("without its index" in line for line in bag.problems)
    assert any("has no metadata.yaml" in line for line in bag.problems)
    assert repair(bag, tmp_path / "mended") == 90
    mended = Bag(tmp_path / "mended")
    assert times(mended) == list(range(90))
    assert mended.topics == bag.topics
    assert not mended.problems
    abandoned.close()


def test_a_repaired_bag_of_ros_1_keeps_its_messages(tmp_path: Path) -> None:
    bag = Bag(write_ros1(tmp_path / "a.bag", ENTRIES))
    assert repair(bag, tmp_path / "mended") == len(ENTRIES)
    mended = Bag(tmp_path / "mended")
    assert [m.data for m in mended.messages()] == [m.data for m in bag.messages()]
    assert mended.topics == bag.topics


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
