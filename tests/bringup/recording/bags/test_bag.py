"""Claims: what is written is read again, by others too; damage costs only what is damaged."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest
import yaml
from mcap.writer import Writer
from rosbags.rosbag2 import Reader

from arjuna_core.errors import InputFileError
from bringup.recording.bags import summary
from bringup.recording.bags.reader import Bag
from bringup.recording.bags.repair import repair
from bringup.recording.bags.topic import TopicInfo, TopicQos, dump
from bringup.recording.bags.writer import BagFolder, RecordingError, SplitLimits
from tests.slam.logs.recordings import Cdr, write_humble

NUMBER = TopicInfo(
    "/number", "std_msgs/msg/Int32", "int32 data\n", "RIHS01_0", (TopicQos(depth=5),)
)
LATCHED = TopicInfo(
    "/word", "std_msgs/msg/String", "string data\n", "RIHS01_1", (TopicQos(latched=True, depth=1),)
)
MS = 1_000_000


def write(folder: Path, count: int = 100, limits: SplitLimits | None = None) -> BagFolder:
    """Write a message each millisecond, flushed each ten; the folder is not closed."""
    bag = BagFolder(folder, limits or SplitLimits())
    for number in range(count):
        topic = LATCHED if number % 10 == 0 else NUMBER
        bag.write(topic, number * MS, bytes([0, 1, 0, 0, number % 256, 0, 0, 0]), number * MS)
        if number % 10 == 9:
            bag.flush()
    return bag


def times(bag: Bag) -> list[int]:
    return [message.time // MS for message in bag.messages()]


def test_what_is_written_is_read_by_rosbags_too(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
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
    write(tmp_path / "bag").close()
    assert Bag(tmp_path / "bag").topics == {"/number": NUMBER, "/word": LATCHED}


def test_metadata_says_what_rosbag2_asks_for(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
    text = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())
    found = text["rosbag2_bagfile_information"]
    assert found["storage_identifier"] == "mcap"
    assert found["message_count"] == 100
    assert found["duration"] == {"nanoseconds": 99 * MS}
    assert found["relative_file_paths"] == ["bag_0.mcap"]


@pytest.mark.parametrize("limits", [SplitLimits(size=300), SplitLimits(duration=0.02)])
def test_split_recordings_are_read_as_one(tmp_path: Path, limits: SplitLimits) -> None:
    write(tmp_path / "bag", limits=limits).close()
    bag = Bag(tmp_path / "bag")
    assert len(bag.files) >= 5
    assert [file.name for file in bag.files[:2]] == ["bag_0.mcap", "bag_1.mcap"]
    assert times(bag) == list(range(100))
    (tmp_path / "bag" / "metadata.yaml").unlink()
    (tmp_path / "bag" / "notes.txt").write_text("what lies beside them is none of them")
    assert times(Bag(tmp_path / "bag")) == list(range(100))


def test_an_existing_folder_is_never_written_into(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    with pytest.raises(RecordingError, match="exists already and is not overwritten"):
        BagFolder(tmp_path / "bag")


def test_an_abandoned_recording_is_read_to_the_last_flush_and_mended(tmp_path: Path) -> None:
    abandoned = write(tmp_path / "bag", 95)
    bag = Bag(tmp_path / "bag")
    assert times(bag) == list(range(90))
    assert any("without its index" in line for line in summary.missing(bag))
    assert any("has no metadata.yaml" in line for line in summary.missing(bag))
    assert repair(bag, tmp_path / "mended") == 90
    mended = Bag(tmp_path / "mended")
    assert times(mended) == list(range(90))
    assert mended.topics == bag.topics
    assert not mended.problems
    abandoned.close()


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8, 0.99])
def test_a_file_cut_anywhere_is_read_as_far_as_it_goes(tmp_path: Path, share: float) -> None:
    write(tmp_path / "bag").close()
    whole = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(len(whole) * share)])
    bag = Bag(cut)
    found = times(bag)
    assert found == list(range(len(found)))
    assert len(found) == bag.counts.total()
    assert bag.problems


def test_a_damaged_chunk_costs_only_its_own_messages(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
    path = tmp_path / "bag" / "bag_0.mcap"
    data = bytearray(path.read_bytes())
    place = data.index(b"\x28\xb5\x2f\xfd", len(data) // 4)  # a zstd frame
    data[place + 12 : place + 16] = b"\xff\xff\xff\xff"
    path.write_bytes(data)
    bag = Bag(path)
    found = times(bag)
    assert len(found) == 90
    assert found[-1] == 99
    assert any("damaged" in line for line in bag.problems)


def test_messages_of_overlapping_chunks_come_in_the_order_of_time(tmp_path: Path) -> None:
    path = tmp_path / "mixed.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/Int32", "ros2msg", b"int32 data\n")
        channel = writer.register_channel("/number", "cdr", schema)
        for stamps in ((5, 1, 9), (2, 8, 3)):
            for stamp in stamps:
                writer.add_message(channel, stamp * MS, b"\0\1\0\0", stamp * MS)
            writer.flush()
        writer.finish()
    assert times(Bag(path)) == [1, 2, 3, 5, 8, 9]


def test_reading_begins_where_it_is_asked_to_and_takes_only_what_is_wanted(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
    found = Bag(tmp_path / "bag").messages(lambda topic: topic == "/word", 55 * MS)
    assert [message.time // MS for message in found] == [60, 70, 80, 90]


def test_lost_messages_are_told(tmp_path: Path) -> None:
    write(tmp_path / "bag").close({"/number": 7})
    bag = Bag(tmp_path / "bag")
    assert list(summary.missing(bag)) == [
        "/number: 7 messages were published and never reached the recorder"
    ]


def test_the_summary_is_that_of_ros2_bag_info(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
    lines = list(summary.lines(Bag(tmp_path / "bag")))
    assert lines[0] == "Files:             bag_0.mcap"
    assert "Duration:          0.099000000s" in lines
    assert lines[-2] == (
        "Topic information: Topic: /number | Type: std_msgs/msg/Int32 | Count: 90 | "
        "Serialization Format: cdr"
    )


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


def _packed(folder: Path, storage: str, packed: str) -> Path:
    stored = [
        (LATCHED.name, LATCHED.type_name, 0.001 * n, Cdr().text(f"word {n}").bytes())
        for n in range(2000)
    ]
    return write_humble(folder, stored, storage, packed)


@pytest.mark.parametrize("packed", ["NONE", "FILE", "MESSAGE"])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_compressed_recordings_give_the_same_messages(
    storage: str, packed: str, tmp_path: Path
) -> None:
    bag = Bag(_packed(tmp_path / "bag", storage, packed))
    found = list(bag.messages())
    assert [message.time // MS for message in found] == list(range(2000))
    assert found[7].data == Cdr().text("word 7").bytes()
    assert (bag.counts["/word"], bag.storage, bag.problems) == (2000, storage.lower(), [])


def test_a_cut_database_is_read_told_and_mended(tmp_path: Path) -> None:
    path = _packed(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])
    bag = Bag(path)
    found = times(bag)
    assert 400 < len(found) < 1900
    assert found == list(range(len(found)))
    assert bag.counts.total() == len(found)
    assert any("damaged or cut short" in line for line in bag.problems)
    assert repair(bag, tmp_path / "mended") == len(found)


def test_messages_of_a_database_come_in_the_order_of_time(tmp_path: Path) -> None:
    path = _packed(tmp_path / "bag", "SQLITE3", "NONE") / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("UPDATE messages SET timestamp = 2000000000 - timestamp")
    database.close()
    assert times(Bag(path)) == list(range(1, 2001))


@pytest.mark.parametrize("packed", ["FILE", "MESSAGE"])
def test_what_cannot_be_unpacked_is_told(packed: str, tmp_path: Path) -> None:
    folder = _packed(tmp_path / "bag", "SQLITE3", packed)
    if packed == "FILE":
        (folder / "bag.db3.zstd").write_bytes(b"no archive" * 100)
        with pytest.raises(InputFileError, match=r"bag\.db3\.zstd: cannot be unpacked"):
            Bag(folder)
        return
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE messages SET data = x'28b52ffd00' WHERE id = 3")
    database.close()
    bag = Bag(folder)
    assert len(times(bag)) == 1999
    assert any("/word: a message cannot be unpacked" in line for line in bag.problems)


@pytest.mark.parametrize("name", ["missing.mcap", "text.mcap", "notes.txt", "empty"])
def test_what_is_no_recording_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "text.mcap").write_text("no recording")
    (tmp_path / "notes.txt").write_text("no recording")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputFileError, match=name):
        Bag(tmp_path / name)


def test_a_missing_file_of_a_folder_is_named(tmp_path: Path) -> None:
    write(tmp_path / "bag").close()
    shutil.move(tmp_path / "bag" / "bag_0.mcap", tmp_path / "elsewhere.mcap")
    with pytest.raises(InputFileError, match=r"bag_0\.mcap"):
        Bag(tmp_path / "bag")
