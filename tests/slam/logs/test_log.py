"""Claims: scans are the same from every storage; damage raises only the reader's own error."""

from __future__ import annotations

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
from tests.core.bags.recordings import write, write_humble, write_ros1
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


def test_a_type_that_only_has_the_name_is_refused(tmp_path: Path) -> None:
    other = b"std_msgs/Header header\nfloat64[] ranges\n"
    path = write(tmp_path / "a.mcap", entries(), definition=other)
    with pytest.raises(InputFileError, match="only has the name of sensor_msgs/msg/LaserScan"):
        read(path)
