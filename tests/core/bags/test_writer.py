"""Claims: written recordings are rosbag2's; what a killed writer leaves can be repaired."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from rosbags.rosbag2 import Reader

from arjuna_core.bags.file_writer import RecordingError
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.writer import BagFolder, SplitLimits, repair
from arjuna_core.se2 import SE2
from tests.core.bags.recordings import (
    LATCHED,
    MS,
    NUMBER,
    TF,
    Entry,
    times,
    transform_bytes,
    write_numbers,
    write_ros1,
)

ENTRIES: list[Entry] = [
    ("/tf", TF, 0.1 * k, transform_bytes(("odom", "base_link", SE2(float(k)), 0.1 * k)))
    for k in range(1, 41)
]


def test_what_is_written_is_read_by_rosbags_too(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
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
    assert times(bag) == list(range(100))
    metadata = tmp_path / "bag" / "metadata.yaml"
    files = yaml.safe_load(metadata.read_text())["rosbag2_bagfile_information"]["files"]
    starts = [file["starting_time"]["nanoseconds_since_epoch"] for file in files]
    ends = [a + f["duration"]["nanoseconds"] for a, f in zip(starts, files, strict=True)]
    assert starts == [0, *(end + MS for end in ends[:-1])]
    metadata.unlink()
    (tmp_path / "bag" / "notes.txt").write_text("what lies beside them is none of them")
    assert times(Bag(tmp_path / "bag")) == list(range(100))


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
