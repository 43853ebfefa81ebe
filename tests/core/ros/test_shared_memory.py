"""What killed processes leave in shared memory: what is removed, and what stays."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from arjuna_core.ros.shared_memory import remove_leftovers

SEGMENT = "fastrtps_00112233445566aa"
HOLDS = """
import fcntl, sys
file = open(sys.argv[1])
fcntl.flock(file, fcntl.LOCK_EX)
print("held", flush=True)
sys.stdin.read()
"""


def leftover(folder: Path, name: str, age: float = 60.0) -> Path:
    for path in (folder / name, folder / f"{name}_el"):
        path.write_bytes(b"x")
        os.utime(path, (time.time() - age,) * 2)
    return folder / name


def test_a_segment_stays_while_its_process_lives(tmp_path: Path) -> None:
    segment = leftover(tmp_path, SEGMENT)
    lock = tmp_path / f"{SEGMENT}_el"
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(lock)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        assert remove_leftovers(tmp_path) == 0
        assert segment.exists()
        assert lock.exists()
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert remove_leftovers(tmp_path) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "age"),
    [
        (SEGMENT, 1.0),  # not locked yet
        ("fastrtps_port7000", 1.0),  # not yet ready
        ("sem.fastrtps_port7000_mutex", 60.0),
        ("fastrtps_00112233445566aabb", 60.0),
        ("mine", 60.0),
    ],
)
def test_what_is_young_or_something_else_stays(tmp_path: Path, name: str, age: float) -> None:
    segment = leftover(tmp_path, name, age)
    assert remove_leftovers(tmp_path) == 0
    assert segment.exists()


def test_a_segment_without_its_lock_and_a_folder_that_is_not_there(tmp_path: Path) -> None:
    leftover(tmp_path, SEGMENT).with_name(f"{SEGMENT}_el").unlink()
    assert remove_leftovers(tmp_path) == 0
    assert remove_leftovers(tmp_path / "none") == 0


def test_the_lock_is_given_back_where_nothing_can_be_removed(tmp_path: Path) -> None:
    segment = leftover(tmp_path, SEGMENT)
    segment.unlink()
    segment.mkdir()
    os.utime(segment, (0.0, 0.0))
    assert remove_leftovers(tmp_path) == 0
    with (tmp_path / f"{SEGMENT}_el").open("rb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)


@pytest.mark.parametrize(
    ("start", "is_torn"), [(b"", True), (b"\0" * 64, True), (b"\1", True), (b"\2", False)]
)
def test_a_port_that_was_not_made_to_its_end_is_removed(
    tmp_path: Path, start: bytes, is_torn: bool
) -> None:
    """Each process that met one waited without end."""
    port = tmp_path / "fastrtps_port7009"
    port.write_bytes(start.ljust(4, b"\0") if start else start)
    os.utime(port, (time.time() - 3.0,) * 2)
    assert remove_leftovers(tmp_path) == is_torn
    assert port.exists() is not is_torn
