"""What runs on a log share: progress, a folder to write into, trajectories as text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from bringup.progress import Bar


class Count:
    """Counts the scans of a log as they pass and shows how far it is.

    Args:
        log: What `arjuna_slam.offline.open_log` returned.

    Attributes:
        scans: How many have passed.
        seconds: The time they span [s].
    """

    def __init__(self, log: Any) -> None:
        self._log = log
        self.scans = 0
        self.seconds = 0.0

    def __iter__(self) -> Iterator[Any]:
        """Yield scans and odometry."""
        bar = Bar()
        first = None
        for scan, odometry in self._log:
            first = scan.stamp if first is None else first
            self.scans += 1
            self.seconds = max(self.seconds, scan.stamp - first)
            yield scan, odometry
            bar.show(self._log.progress, f"{self.scans} scans")
        bar.finish(f"{self.scans} scans")


def make_folder(out: Path) -> None:
    """Make a folder and those above it.

    Raises:
        InputFileError: That cannot be done.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = f"cannot be written: {error.strerror}; valid: a folder that can be written"
        raise InputFileError(out, problem) from error


def tum(entry: tuple[float, SE2]) -> str:
    """Return stamp [s] and pose as a line `time x y z qx qy qz qw`."""
    stamp, pose = entry
    z, w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    return f"{stamp:.6f} {pose.x:.6f} {pose.y:.6f} 0 0 0 {z:.9f} {w:.9f}\n"
