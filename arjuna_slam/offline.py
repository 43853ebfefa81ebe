"""SLAM on recorded logs of CARMEN and ROS, and the error against reference relations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.logs.carmen import COMPRESSED, CarmenLog, read_carmen
from arjuna_slam.logs.recording import Recording, RecordingTopics
from arjuna_slam.logs.storage import SUFFIXES
from arjuna_slam.slam import Slam

__all__ = ["RecordingTopics", "RelationError", "evaluate", "open_log", "read_carmen", "run"]
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
        path: `.clf` or `.log`, also compressed; `.mcap`, `.db3`, ROS 1's `.bag`; a rosbag2 folder.
        topics: What is read of a recording.

    Raises:
        InputFileError: It does not exist or is of another kind.
    """
    if not path.exists():
        raise InputFileError(path, "does not exist")
    suffixes = [suffix.lower() for suffix in path.suffixes]
    if path.is_dir() or (suffixes and suffixes[-1] in SUFFIXES):
        return Recording(path, topics)
    if suffixes[-1:] and suffixes[-1] in COMPRESSED:
        suffixes.pop()
    if suffixes[-1:] and suffixes[-1] in _CARMEN:
        return CarmenLog(path)
    carmen = f"{', '.join(_CARMEN)} (also with {', '.join(COMPRESSED)})"
    valid = f"{carmen}, {', '.join(SUFFIXES)}, rosbag2 folders"
    raise InputFileError(path, f"is of no kind that can be read; valid: {valid}")


def run(slam: Slam, log: Iterable[tuple[Scan, SE2]]) -> list[tuple[float, SE2]]:
    """Feed a log and return stamp [s] and optimised pose in map of every usable scan, by stamp.

    Loggers stamp some scans too early or late (the Intel log 631 of 13631): the order of the log is
    believed and the stamps given to SLAM are raised where they would step back.
    """
    hung: list[tuple[float, int, SE2]] = []
    last = -math.inf
    for scan, T_odom_base in log:
        last = max(scan.stamp, math.nextafter(last, math.inf))
        update = slam.process(replace(scan, stamp=last), T_odom_base)
        if update is not None:
            hung.append((scan.stamp, update.node, update.T_node_base))
    slam.optimize()
    hung.sort(key=lambda entry: entry[0])
    return [(stamp, slam.graph.pose(node) @ pose) for stamp, node, pose in hung]


@dataclass(frozen=True)
class RelationError:
    """Error of a trajectory against relations.

    Attributes:
        translation: Mean and standard deviation [m].
        rotation: Mean and standard deviation [rad].
        count: Relations evaluated.
    """

    translation: tuple[float, float]
    rotation: tuple[float, float]
    count: int


def evaluate(trajectory: list[tuple[float, SE2]], relations: NDArray[np.float64]) -> RelationError:
    """Compare a trajectory with reference relations.

    Args:
        trajectory: Stamps [s], increasing, and poses; between two, poses are interpolated.
        relations: `(R, 8) float64`: t1, t2, x, y, z, roll, pitch, yaw of the pose at t2 in that
            at t1.

    Raises:
        ValueError: No relation lies within the trajectory.

    Source: Kuemmerle et al., On measuring the accuracy of SLAM algorithms, 2009.
    """
    stamps = np.array([stamp for stamp, _ in trajectory])
    times = relations[:, :2]
    relations = relations[((times >= stamps[0]) & (times <= stamps[-1])).all(axis=1)]
    if len(relations) == 0:
        raise ValueError(f"no relation within {stamps[0]:.3f}..{stamps[-1]:.3f} s")
    error = np.empty((len(relations), 2))
    for k, row in enumerate(relations):
        first, second = (_at(stamps, trajectory, t) for t in row[:2])
        e = SE2(row[2], row[3], row[7]).inverse() @ (first.inverse() @ second)
        error[k] = math.hypot(e.x, e.y), abs(wrap(e.theta))
    mean, deviation = error.mean(axis=0), error.std(axis=0)
    return RelationError(
        (float(mean[0]), float(deviation[0])), (float(mean[1]), float(deviation[1])), len(error)
    )


def _at(stamps: NDArray[np.float64], trajectory: list[tuple[float, SE2]], stamp: float) -> SE2:
    k = int(np.searchsorted(stamps, stamp))
    if k == 0 or stamps[k] == stamp:
        return trajectory[k][1]
    ratio = (stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
    return trajectory[k - 1][1].interpolate(trajectory[k][1], float(ratio))
