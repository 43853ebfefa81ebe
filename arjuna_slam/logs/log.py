"""Logs of any kind: scans with the odometry at their stamps."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from arjuna_core.bags.reader import PACKED, SUFFIXES
from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.carmen import COMPRESSED, CarmenLog
from arjuna_slam.logs.recording import Recording, RecordingTopics

_CARMEN = (".clf", ".log")


class Log(Protocol):
    """Scans with the odometry at their stamps, in the order in which they were taken."""

    @property
    def problems(self) -> list[str]:
        """What was passed over."""

    @property
    def progress(self) -> float:
        """Share (0..1) of the log that has been read."""

    def __iter__(self) -> Iterator[tuple[Scan, SE2]]:
        """Yield scans and `T_odom_base`."""


def open_log(path: Path, topics: RecordingTopics) -> Log:
    """Return the log in a file: CARMEN's, or a recording.

    Args:
        path: `.clf` or `.log`, also compressed; `.mcap`, `.db3`, ROS 1's `.bag`, also with
            `.zstd`; a rosbag2 folder.
        topics: What is read of a recording.

    Raises:
        InputFileError: It does not exist or is of another kind.
    """
    if not path.exists():
        raise InputFileError(path, "does not exist")
    suffixes = [suffix.lower() for suffix in path.suffixes]
    unpacked = suffixes[:-1] if suffixes[-1:] == [PACKED] else suffixes
    if path.is_dir() or (unpacked and unpacked[-1] in SUFFIXES):
        return Recording(path, topics)
    if suffixes[-1:] and suffixes[-1] in COMPRESSED:
        suffixes.pop()
    if suffixes[-1:] and suffixes[-1] in _CARMEN:
        return CarmenLog(path)
    carmen = f"{', '.join(_CARMEN)} (also with {', '.join(COMPRESSED)})"
    valid = f"{carmen}, {', '.join(SUFFIXES)} (also with {PACKED}), rosbag2 folders"
    raise InputFileError(path, f"is of no kind that can be read; valid: {valid}")
