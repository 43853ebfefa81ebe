"""Claims: damage of an mcap file costs only what is damaged, and is reported."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.writer import Writer

from arjuna_core.bags.reader import Bag
from tests.core.bags.recordings import MS, times, write_numbers


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
