"""Recordings of each format read back whole, cut short too."""

from __future__ import annotations

import bz2
import shutil
import sqlite3
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import lz4.frame
import pytest
from mcap.writer import Writer
from rosbags.rosbag1 import ReaderError

from arjuna_core.bags import ros1_file
from arjuna_core.bags.decoder import DecodeError, Decoder, is_standard
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import (
    BagMessage,
    TopicInfo,
    TopicQos,
    dump,
    offer_for,
    parse,
    request_for,
)
from arjuna_core.errors import InputFileError
from tests.core.bags.recordings import (
    ENTRIES,
    LATCHED,
    MS,
    NUMBER,
    Cdr,
    times,
    write_numbers,
    write_ros1,
    write_words,
)


@pytest.mark.parametrize("packed", ["NONE", "FILE", "MESSAGE"])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_compressed_recordings_read_the_same(storage: str, packed: str, tmp_path: Path) -> None:
    bag = Bag(write_words(tmp_path / "bag", storage, packed))
    assert bag.share == 0.0
    found = list(bag.messages())
    assert 0.9 < bag.share <= 1.0
    assert [message.time // MS for message in found] == list(range(2000))
    assert found[7].data == Cdr().text("word 7").bytes()
    assert (bag.counts["/word"], bag.storage, bag.problems) == (2000, storage.lower(), [])


@pytest.mark.parametrize("packed", ["FILE", "MESSAGE"])
def test_what_cannot_be_unpacked_is_named(packed: str, tmp_path: Path) -> None:
    folder = write_words(tmp_path / "bag", "SQLITE3", packed)
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
    write_numbers(tmp_path / "bag").close()
    shutil.move(tmp_path / "bag" / "bag_0.mcap", tmp_path / "elsewhere.mcap")
    with pytest.raises(InputFileError, match=r"bag_0\.mcap"):
        Bag(tmp_path / "bag")


OWN = TopicInfo("/own", "own/msg/Pair")
WORD = f"{'=' * 80}\nMSG: own/Word\nstring data\n"


def test_messages_of_types_that_the_recording_defines_are_decoded() -> None:
    own = replace(OWN, definition=f"int32 number\nown/Word word\n{WORD}")
    data = Cdr().put("i", 7).text("seven").bytes()
    decoder = Decoder()
    for _ in range(2):
        pair = decoder.decode(own, data)
        assert (pair.number, pair.word.data) == (7, "seven")
    for definition in ("", "int32 data"):
        number = TopicInfo("/n", "std_msgs/msg/Int32", definition=definition)
        assert decoder.decode(number, Cdr().put("i", 5).bytes()).data == 5
        assert is_standard(number)
    assert not is_standard(replace(number, definition="int64 data"))
    assert is_standard(own)


@pytest.mark.parametrize(
    ("topic", "problem"),
    [
        (replace(NUMBER, encoding="json"), "/number is encoded as 'json'; valid: cdr, ros1"),
        (replace(NUMBER, type_name="own/msg/None", definition=""), "own/msg/None: "),
        (replace(NUMBER, type_name="own/msg/None", definition="!"), "own/msg/None: "),
        (replace(LATCHED, definition=""), "std_msgs/msg/String: "),
    ],
)
def test_what_cannot_be_decoded_is_said(topic: TopicInfo, problem: str) -> None:
    with pytest.raises(DecodeError, match=problem):
        Decoder().decode(topic, Cdr().put("i", 99).bytes())


STRONG, WEAK = TopicQos(latched=True, depth=1), TopicQos(reliable=False, depth=5)


def test_profiles_survive_their_text() -> None:
    assert parse(dump([STRONG, WEAK])) == (STRONG, WEAK)


def test_the_numbers_of_old_recordings_are_understood() -> None:
    text = "- {history: 1, depth: 1, reliability: 1, durability: 1}\n- {reliability: 2, depth: 5}"
    assert parse(text) == (STRONG, WEAK)


@pytest.mark.parametrize("text", ["", "{", "7", "- 7"])
def test_what_cannot_be_read_is_left_out(text: str) -> None:
    assert parse(text) == ()


def test_a_request_matches_the_weakest_and_an_offer_the_strongest() -> None:
    assert request_for([STRONG, WEAK]) == TopicQos(reliable=False, latched=False)
    assert request_for([STRONG]) == TopicQos(reliable=True, latched=True)
    assert offer_for([STRONG, WEAK]) == TopicQos(reliable=True, latched=True, depth=5)
    assert offer_for([]) == TopicQos(reliable=True, latched=False, depth=100)
    assert offer_for([STRONG], publishers=100).depth == 100


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8, 0.99])
def test_a_file_cut_anywhere_is_read_as_far_as_it_goes(tmp_path: Path, share: float) -> None:
    write_numbers(tmp_path / "bag").close()
    whole = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(len(whole) * share)])
    bag = Bag(cut)
    found = times(bag)
    assert found == list(range(len(found)))
    assert len(found) == bag.counts.total()
    assert bag.problems


def test_a_damaged_chunk_costs_only_its_own_messages(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    path = tmp_path / "bag" / "bag_0.mcap"
    data = bytearray(path.read_bytes())
    offset = data.index(b"\x28\xb5\x2f\xfd", len(data) // 4)  # a zstd frame
    data[offset + 12 : offset + 16] = b"\xff\xff\xff\xff"
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


def test_a_chunk_that_holds_more_than_it_says_is_not_unpacked(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    path = tmp_path / "bag" / "bag_0.mcap"
    data = bytearray(path.read_bytes())
    chunk = 17 + int.from_bytes(data[9:17], "little")
    assert data[chunk] == 6
    data[chunk + 25 : chunk + 33] = (100).to_bytes(8, "little")
    path.write_bytes(data)
    bag = Bag(path)
    assert times(bag) == list(range(10, 100))
    assert "a chunk of 100 bytes holds 101" in " ".join(bag.problems)


def test_reading_begins_where_it_is_asked_to_and_takes_only_what_is_wanted(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    found = Bag(tmp_path / "bag").messages(lambda topic: topic == "/word", 55 * MS)
    assert [message.time // MS for message in found] == [60, 70, 80, 90]


def read(path: Path) -> tuple[list[BagMessage], list[str]]:
    bag = Bag(path)
    return list(bag.messages()), bag.problems


def test_a_whole_bag_is_read_in_the_order_of_time(tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", [*ENTRIES[20:], *ENTRIES[:20]], chunk=500)
    messages, problems = read(path)
    assert [round(m.time / 1e8) for m in messages] == list(range(1, 41))
    assert problems == []
    bag = Bag(path)
    assert (bag.storage, bag.counts["/tf"], bag.topics["/tf"].encoding) == ("rosbag1", 40, "ros1")
    assert (bag.start, bag.end) == (100 * MS, 4000 * MS)
    for start in (0, 100, 101, 2000, 4000, 4001):
        kept = [m for m in messages if m.time >= start * MS]
        assert list(bag.messages(start=start * MS)) == kept
    assert list(bag.messages(lambda topic: False)) == []


def test_a_bag_without_its_index_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES, chunk=500)
    whole, _ = read(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    messages, problems = read(path)
    assert 5 < len(messages) < 30
    assert messages == whole[: len(messages)]
    assert "damaged or cut short" in " ".join(problems)


def test_a_ros1_chunk_larger_than_it_says_is_not_unpacked(tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES, chunk=500)
    data = path.read_bytes()
    at = data.index(b"size=", data.index(b"compression=")) + 5
    path.write_bytes(data[:at] + (100).to_bytes(4, "little") + data[at + 4 :])
    messages, problems = read(path)
    assert len(messages) < len(ENTRIES)
    assert "a chunk of 100 bytes holds 101" in " ".join(problems)


@pytest.mark.parametrize(
    ("unpack", "pack"),
    [(ros1_file._bz2, bz2.compress), (ros1_file._lz4, lz4.frame.compress)],
    ids=["bz2", "lz4"],
)
def test_no_more_is_unpacked_than_a_chunk_may_hold(
    unpack: Callable[[bytes, int], bytes],
    pack: Callable[[bytes], bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ros1_file, "_CHUNK_MAX", 100)
    assert unpack(pack(b"x" * 50), 50) == b"x" * 50
    with pytest.raises(ReaderError, match="a chunk of 9000 bytes holds 101"):
        unpack(pack(b"x" * 9000), 9000)


@pytest.mark.parametrize("spoil", [lambda data: b"no recording" * 100, lambda data: data[:4200]])
def test_a_file_that_is_no_bag_is_refused(spoil: Callable[[bytes], bytes], tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES)
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(InputFileError, match="is no bag recording"):
        Bag(path)
