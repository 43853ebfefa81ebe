"""Claims: bags of any ROS and storage give the same scans; damaged ones as far as they go."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from tests.slam.logs.recordings import write, write_humble, write_ros1
from tests.slam.logs.test_recording import LOG, entries

Make = Callable[[Path], Path]


def bare(folder: Path) -> Path:
    return write_humble(folder / "bag", entries()) / "bag.db3"


def without_definitions(folder: Path) -> Path:
    path = bare(folder)
    database = sqlite3.connect(path)
    database.execute("DROP TABLE message_definitions")
    database.commit()
    database.close()
    return path


def packed(storage: str, what: str) -> Make:
    return lambda folder: write_humble(folder / "bag", entries(), storage, what)


STORED: dict[str, Make] = {
    "a rosbag2 folder in SQLite": lambda folder: write_humble(folder / "bag", entries()),
    "a bare db3": bare,
    "a db3 as Humble writes it, without definitions": without_definitions,
    "a rosbag2 folder in mcap": lambda folder: write_humble(folder / "bag", entries(), "MCAP"),
    "each message compressed, in SQLite": packed("SQLITE3", "MESSAGE"),
    "each file compressed, in SQLite": packed("SQLITE3", "FILE"),
    "each message compressed, in mcap": packed("MCAP", "MESSAGE"),
    "each file compressed, in mcap": packed("MCAP", "FILE"),
    "a compressed file alone": lambda folder: next(
        write_humble(folder / "bag", entries(), packed="FILE").glob("*.zstd")
    ),
    "a bag of ROS 1": lambda folder: write_ros1(folder / "a.bag", entries()),
}


def read(path: Path) -> tuple[list[tuple[Scan, SE2]], list[str]]:
    log = open_log(path, RecordingTopics())
    pairs = list(log)
    assert 0.0 <= log.progress <= 1.0
    return pairs, log.problems


@pytest.mark.parametrize("name", STORED)
def test_the_same_messages_are_read_from_every_storage(name: str, tmp_path: Path) -> None:
    pairs, problems = read(STORED[name](tmp_path))
    known, _ = read(write(tmp_path / "known.mcap", entries()))
    assert len(pairs) == len(LOG)
    assert problems == []
    for (scan, pose), (known_scan, known_pose) in zip(pairs, known, strict=True):
        assert pose == known_pose
        assert scan.stamp == known_scan.stamp
        assert scan.T_base_sensor == known_scan.T_base_sensor
        np.testing.assert_array_equal(scan.ranges, known_scan.ranges)


def test_a_database_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = bare(tmp_path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])
    pairs, problems = read(path)
    assert 0.3 * len(LOG) < len(pairs) < 0.9 * len(LOG)
    assert "damaged or cut short" in " ".join(problems)


def test_what_a_killed_recorder_left_in_its_log_is_read_and_nothing_changed(
    tmp_path: Path,
) -> None:
    source = tmp_path / "source"
    source.mkdir()
    database = sqlite3.connect(bare(source))
    database.execute("PRAGMA journal_mode = WAL")
    database.execute("DELETE FROM messages WHERE id > 20")
    database.commit()
    for name in ("bag.db3", "bag.db3-wal"):
        shutil.copy(source / "bag" / name, tmp_path / name)
    database.close()
    before = (tmp_path / "bag.db3").read_bytes()
    pairs, _ = read(tmp_path / "bag.db3")
    assert 5 < len(pairs) < 15
    assert (tmp_path / "bag.db3").read_bytes() == before


def test_an_unfinished_transaction_beside_a_database_does_not_stop_it(tmp_path: Path) -> None:
    path = bare(tmp_path)
    path.with_name("bag.db3-journal").write_bytes(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7" * 100)
    pairs, _ = read(path)
    assert len(pairs) == len(LOG)


def with_view(path: Path) -> None:
    database = sqlite3.connect(path)
    database.execute("DROP TABLE messages")
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
    database.execute(f"CREATE VIEW messages AS {endless} SELECT i AS id, 1 AS topic_id FROM n")
    database.commit()
    database.close()


@pytest.mark.parametrize(
    ("suffix", "spoil", "problem"),
    [
        (".db3", lambda p: p.write_bytes(b"no recording" * 100), "is no db3 recording: file is"),
        (".db3", lambda p: p.write_bytes(b""), "no table messages or topics"),
        (".db3", with_view, "no table messages"),
        (".bag", lambda p: p.write_bytes(b"no recording" * 100), "is no bag recording"),
        (".bag", lambda p: p.write_bytes(p.read_bytes()[:5000]), "is no bag recording"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_own_error(
    suffix: str, spoil: Callable[[Path], None], problem: str, tmp_path: Path
) -> None:
    path = bare(tmp_path) if suffix == ".db3" else write_ros1(tmp_path / "a.bag", entries())
    spoil(path)
    with pytest.raises(InputFileError, match=problem):
        read(path)


@pytest.mark.parametrize("suffix", [".mcap", ".db3", ".bag"])
def test_random_damage_raises_nothing_but_the_readers_own_error(
    suffix: str, tmp_path: Path
) -> None:
    some = entries(odometry=True)[:60]
    path = {
        ".mcap": lambda: write(tmp_path / "a.mcap", some),
        ".db3": lambda: write_humble(tmp_path / "bag", some) / "bag.db3",
        ".bag": lambda: write_ros1(tmp_path / "a.bag", some),
    }[suffix]()
    whole, rng = path.read_bytes(), np.random.default_rng(4)
    for _ in range(60):
        damaged = bytearray(whole)
        for at in rng.integers(0, len(whole), 20).tolist():
            damaged[at] = int(rng.integers(256))
        path.write_bytes(damaged[: int(rng.integers(len(whole) // 2, len(whole) + 1))])
        try:
            read(path)
        except InputFileError:
            continue


def test_a_chunk_that_holds_more_than_it_says_is_not_unpacked(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", entries(False, True))
    data = bytearray(path.read_bytes())
    chunk = 17 + int.from_bytes(data[9:17], "little")
    assert data[chunk] == 6
    data[chunk + 25 : chunk + 33] = (1000).to_bytes(8, "little")
    path.write_bytes(data)
    log = open_log(path, RecordingTopics())
    assert 0 < len(list(log)) < len(LOG), "the summary names the topics that it names"
    assert "a chunk of 1000 bytes holds 1001" in " ".join(log.problems)


def test_a_damaged_chunk_of_a_recording_costs_only_its_own_scans(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", entries(), chunk=4000)
    data = bytearray(path.read_bytes())
    place = data.index(b"\x28\xb5\x2f\xfd", len(data) // 3)  # a zstd frame
    data[place + 12 : place + 16] = b"\xff\xff\xff\xff"
    path.write_bytes(data)
    pairs, problems = read(path)
    assert 0.8 * len(LOG) < len(pairs) < len(LOG)
    assert pairs[-1][0].stamp == pytest.approx(LOG[-1][0].stamp)
    assert "bytes are damaged" in " ".join(problems)


def test_a_type_that_only_has_the_name_is_refused(tmp_path: Path) -> None:
    other = b"std_msgs/Header header\nfloat64[] ranges\n"
    path = write(tmp_path / "a.mcap", entries(), definition=other)
    with pytest.raises(InputFileError, match="only has the name of sensor_msgs/msg/LaserScan"):
        read(path)
