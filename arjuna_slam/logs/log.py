"""Logs of any kind: scans with the odometry at their stamps."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.bags.reader import PACKED, SUFFIXES
from arjuna_core.errors import InputFileError, shortened
from arjuna_core.files.input_file import UNPACKERS, UNPACKING, open_file, read_lines
from arjuna_core.ros.health.rules import GREATEST
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.logs.recording import Recording, RecordingTopics

_RANGE_MAX = 80.0  # readings at the scanner's maximum mean no return

COMPRESSED = tuple(UNPACKERS)
"""Suffixes of compressed logs."""
_CARMEN = (".clf", ".log")


class CarmenLog:
    """The scans of a CARMEN log, as text or compressed, each with the odometry.

    Attributes:
        progress: Share (0..1) of the log that has been read.

    Raises:
        InputFileError: It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.problems: list[str] = []
        self._path = path
        self.progress = 0.0
        self._idle = 0  # lines since the last scan
        open_file(path).close()  # raises early

    def __iter__(self) -> Iterator[tuple[Scan, SE2]]:
        """Yield scans and odometry.

        Raises:
            InputFileError: It holds no scan that can be read.
        """
        given = 0
        bad: list[str] = []
        for entry in read_carmen(self._lines(), problems=bad):
            given += 1
            self._idle = 0
            yield entry
        if given == 0:
            reason = (bad + self.problems + ["no line begins with FLASER or ROBOTLASER1"])[0]
            raise InputFileError(self._path, f"is no CARMEN log with scans: {reason}")
        if bad:
            self.problems.append(f"{len(bad)} lines could not be read; the first, {bad[0]}")

    def _lines(self) -> Iterator[str]:
        try:
            for line, share in read_lines(self._path):
                self.progress = share
                self._idle += 1
                if self._idle > 200_000:
                    raise InputFileError(self._path, "has over 200 000 lines without a scan")
                yield line.decode("ascii", "replace")
        except UNPACKING as error:
            self.problems.append(f"damaged or cut short ({error}); read up to there")


def read_carmen(
    lines: Iterable[str], T_base_sensor: SE2 | None = None, problems: list[str] | None = None
) -> Iterator[tuple[Scan, SE2]]:
    """Yield scan and odometry of each FLASER and ROBOTLASER1 line.

    A FLASER scan spans 180 degrees: 180 beams of 1 degree, or 360 or 361 of 0.5; ROBOTLASER1 says
    what it spans. The scanner's pose is that of the first line, where none is given. Lines that
    cannot be read are added to `problems`.

    Raises:
        ValueError: A line cannot be read, and `problems` is None.
    """
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0] not in _READERS:
            continue
        try:
            scan, laser, odometry = _READERS[words[0]](words[1:])
        except ValueError as error:
            if problems is None:
                raise ValueError(f"line {number}: {error}") from error
            kept = len(problems) < 1000  # of a broken file the first are enough
            problems.append(f"line {number}: {shortened(str(error), 200)}" if kept else "")
            continue
        if T_base_sensor is None:
            T_base_sensor = _mount(odometry.inverse() @ laser)
        yield replace(scan, T_base_sensor=T_base_sensor), odometry


def _mount(offset: SE2) -> SE2:
    offset_max = 1.0  # [m]; a laser further off was corrected by another program
    return offset if math.hypot(offset.x, offset.y) < offset_max else IDENTITY


def _read_flaser(words: list[str]) -> tuple[Scan, SE2, SE2]:
    count = _count(words, 0)
    _check_length(words, count + 10)
    ranges = _numbers(words[1 : 1 + count])
    numbers = _finite(words[count + 1 : count + 8])
    increment = math.pi / max(1, count if count % 2 == 0 else count - 1)
    scan = _scan(ranges, -0.5 * math.pi, increment, _RANGE_MAX, float(numbers[6]))
    return scan, SE2.from_array(numbers[:3]), SE2.from_array(numbers[3:6])


def _read_robotlaser(words: list[str]) -> tuple[Scan, SE2, SE2]:
    """Laser, readings, remissions, then laser and robot pose, five more numbers and the stamp."""
    count = _count(words, 7)
    after = 9 + count + _count(words, 8 + count)
    _check_length(words, after + 14)
    angle_min, _, increment, range_max = (float(word) for word in words[1:5])
    numbers = _finite(words[after : after + 12])
    reach = min(range_max - 0.01, _RANGE_MAX) if range_max > 0.0 else _RANGE_MAX
    ranges = _numbers(words[8 : 8 + count])
    scan = _scan(ranges, angle_min, increment, reach, float(numbers[11]))
    return scan, SE2.from_array(numbers[:3]), SE2.from_array(numbers[3:6])


def _count(words: list[str], index: int) -> int:
    word = words[index] if index < len(words) else "missing"
    if not word.isdigit():
        raise ValueError(f"the number of readings is {word}; valid: a whole number")
    return int(word)


def _check_length(words: list[str], valid: int) -> None:
    if len(words) < valid:
        raise ValueError(f"{len(words) + 1} words, {valid + 1} are valid")


def _numbers(words: list[str]) -> Floats:
    return np.array(words, dtype=np.float64)


def _finite(words: list[str]) -> Floats:
    """Return numbers of which none may be absent: poses and a stamp."""
    numbers = _numbers(words)
    if not (np.abs(numbers) <= GREATEST).all():
        raise ValueError(f"a pose or stamp of {' '.join(words)} is not finite or too great")
    return numbers


def _scan(ranges: Floats, angle_min: float, increment: float, reach: float, stamp: float) -> Scan:
    ranges[ranges >= reach] = math.inf
    return Scan(ranges, angle_min, increment, 0.02, reach, stamp)


_READERS = {"FLASER": _read_flaser, "ROBOTLASER1": _read_robotlaser}


class Log(Protocol):
    """Scans with the odometry at their stamps, in the order in which they were taken."""

    @property
    def problems(self) -> list[str]:
        """The parts that were skipped."""

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

    Raises:
        InputFileError: It does not exist or is of another kind.
    """
    if not os.path.lexists(path):
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
