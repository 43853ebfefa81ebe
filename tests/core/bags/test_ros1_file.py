"""Claims: bags of ROS 1 are read by their index, and without one as far as they go."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from tests.core.bags.recordings import MS, TF, Entry, transform_bytes, write_ros1

ENTRIES: list[Entry] = [
    ("/tf", TF, 0.1 * k, transform_bytes(("odom", "base_link", SE2(float(k)), 0.1 * k)))
    for k in range(1, 41)
]


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
    assert len(list(bag.messages(start=2000 * MS))) == 21
    assert list(bag.messages(lambda topic: False)) == []


def test_a_bag_without_its_index_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES, chunk=500)
    whole, _ = read(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    messages, problems = read(path)
    assert 5 < len(messages) < 30
    assert messages == whole[: len(messages)]
    assert "damaged or cut short" in " ".join(problems)


def test_a_chunk_that_holds_more_than_it_says_is_not_unpacked(tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES, chunk=500)
    data = path.read_bytes()
    at = data.index(b"size=", data.index(b"compression=")) + 5
    path.write_bytes(data[:at] + (100).to_bytes(4, "little") + data[at + 4 :])
    messages, problems = read(path)
    assert len(messages) < len(ENTRIES)
    assert "a chunk of 100 bytes holds 101" in " ".join(problems)


@pytest.mark.parametrize("spoil", [lambda data: b"no recording" * 100, lambda data: data[:4200]])
def test_a_file_that_is_no_bag_is_refused(spoil: Callable[[bytes], bytes], tmp_path: Path) -> None:
    path = write_ros1(tmp_path / "a.bag", ENTRIES)
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(InputFileError, match="is no bag recording"):
        Bag(path)
