"""What runs on a log share: progress, a report, and the files that are written."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.errors import InputFileError
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import Log
from bringup.progress import Bar
from bringup.viewing.pictures import draw_path

ARTIFACTS = ("trajectory.tum", "report.json", "plot.png")
"""What `write` writes."""


class Progress:
    """Counts the scans of a log and the time they take, and shows how far it is.

    Args:
        out: The folder of the results; it is made when the first scan is asked for.
    """

    def __init__(self, out: Path) -> None:
        self._out = out
        self._scans = 0
        self._seconds = 0.0

    def watch(self, log: Log) -> Iterator[tuple[Scan, SE2]]:
        """Yield a log's scans and odometry.

        Raises:
            InputFileError: The folder cannot be made.
        """
        make_folder(self._out)
        self._start = time.monotonic(), time.process_time()
        bar, first = Bar(), None
        for scan, odometry in log:
            first = scan.stamp if first is None else first
            self._scans += 1
            self._seconds = max(self._seconds, scan.stamp - first)
            yield scan, odometry
            bar.show(log.progress, f"{self._scans} scans")
        bar.finish(f"{self._scans} scans")

    def report(self, path: Path, trajectory: list[tuple[float, SE2]]) -> dict[str, Any]:
        """Return what there is to say of any run, at its end.

        Args:
            path: The log.
            trajectory: Stamps [s] and poses.
        """
        spent = time.monotonic() - self._start[0]
        points = np.array([(pose.x, pose.y) for _, pose in trajectory])
        return {
            "input": str(path),
            "scans": self._scans,
            "log_s": self._seconds,
            "time_s": spent,
            "cpu_s": time.process_time() - self._start[1],
            "realtime_factor": self._seconds / max(spent, 1e-9),
            "path_length_m": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        }


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


def write(
    out: Path, report: dict[str, Any], grid: OccupancyGrid, trajectory: list[tuple[float, SE2]]
) -> None:
    """Write a trajectory as text and drawn on a map, and a report.

    Args:
        out: The folder.
        report: The report.
        grid: The map.
        trajectory: Stamps [s] and poses.

    Raises:
        InputFileError: That cannot be done.
    """
    try:
        (out / ARTIFACTS[0]).write_text("".join(map(tum, trajectory)), encoding="ascii")
        (out / ARTIFACTS[1]).write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        draw_path(out / ARTIFACTS[2], grid, np.array([pose.array() for _, pose in trajectory]))
    except OSError as error:
        raise InputFileError(out, f"cannot be written: {error.strerror}") from error


def tum(entry: tuple[float, SE2]) -> str:
    """Return stamp [s] and pose as a line `time x y z qx qy qz qw`."""
    stamp, pose = entry
    z, w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    return f"{stamp:.6f} {pose.x:.6f} {pose.y:.6f} 0 0 0 {z:.9f} {w:.9f}\n"


def summary(
    name: str, report: dict[str, Any], rows: list[tuple[str, str]], problems: list[str], made: str
) -> str:
    """Return a report as text.

    Args:
        name: What ran.
        report: The report.
        rows: What is particular to it.
        problems: What of the log was passed over.
        made: What was written, and where.
    """
    pace = f"{report['realtime_factor']:.0f} x real time ({report['time_s']:.1f} s)"
    lines = [
        *rows,
        ("path", f"{report['path_length_m']:.1f} m in {report['log_s']:.0f} s"),
        ("speed", pace),
        *(("note", problem) for problem in problems),
        ("artifacts", made),
    ]
    return "\n".join([f"{name}, {report['input']}", *(f"  {a:11}{b}" for a, b in lines)])
