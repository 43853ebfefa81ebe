"""Claims: changed files of every kind are read or refused, by the one error of their reader."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from tests.core.bags.recordings import write_ros1
from tests.fuzz.files import READERS, Fuzzer, Reader, log_entries

INPUTS = 30  # of each kind; `bench fuzz` reads as many as there is time for


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_a_changed_file_is_read_or_refused(tmp_path: Path, reader: Reader) -> None:
    fuzzer = Fuzzer(reader, tmp_path, seed=7)
    found = [finding for finding in (fuzzer.once() for _ in range(INPUTS)) if finding is not None]
    assert not found, {finding.problem for finding in found}


def test_a_ros_1_bag_without_transforms_is_read_by_its_odometry(tmp_path: Path) -> None:
    """The rosbags library takes no topic for every topic."""
    entries = [entry for entry in log_entries() if entry[0] != "/tf"]
    path = write_ros1(tmp_path / "run.bag", entries)
    assert len(list(open_log(path, RecordingTopics()))) > 0


def test_a_carmen_line_with_an_invalid_pose_is_skipped(tmp_path: Path) -> None:
    path = next(reader for reader in READERS if reader.name == "CARMEN").make(tmp_path)
    text = path.read_text(encoding="ascii")
    path.write_text(text.replace("2.0 0.1 0.2 2.0", "inf 0.1 0.2 1e300"), encoding="ascii")
    log = open_log(path, RecordingTopics())
    assert len(list(log)) == 4
    assert "not finite or too great" in log.problems[0]


def test_a_message_of_no_number_in_a_db3_file_is_passed_over(tmp_path: Path) -> None:
    path = next(reader for reader in READERS if reader.name == "db3 as log").make(tmp_path)
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA writable_schema = ON")
        database.execute(
            "UPDATE sqlite_schema SET sql = replace(sql, 'INTEGER PRIMARY KEY', 'TEXT') "
            "WHERE name = 'messages'"
        )
        database.commit()
    with pytest.raises(InputFileError, match="no scan can be used"):
        list(open_log(path, RecordingTopics()))
