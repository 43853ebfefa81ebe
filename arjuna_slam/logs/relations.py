"""The error of a trajectory against reference relations.

Source: Kuemmerle et al., On measuring the accuracy of SLAM algorithms, 2009.
"""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text
from arjuna_core.se2 import SE2, wrap


def read_relations(path: Path) -> Floats:
    """Read relations as `evaluate` takes them, a line each.

    Raises:
        InputFileError: It cannot be read as such.
    """
    try:
        relations = np.loadtxt(io.StringIO(read_text(path, 20_000_000)), ndmin=2)
    except ValueError as error:
        raise InputFileError(path, f"cannot be read as relations: {error}") from error
    if relations.shape[1] != 8:
        problem = f"has {relations.shape[1]} columns; valid: t1 t2 x y z roll pitch yaw"
        raise InputFileError(path, problem)
    return relations


@dataclass(frozen=True)
class RelationError:
    """Error of a trajectory against relations."""

    translation: tuple[float, float]  # mean and standard deviation [m]
    rotation: tuple[float, float]  # mean and standard deviation [rad]
    count: int  # relations evaluated


def evaluate(trajectory: list[tuple[float, SE2]], relations: Floats) -> RelationError:
    """Compare a trajectory, increasing stamps [s] and poses, with reference relations.

    A relation is t1, t2, x, y, z, roll, pitch, yaw of the pose at t2 in that at t1: `(R, 8)`.

    Raises:
        ValueError: No relation lies within the trajectory.
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


def _at(stamps: Floats, trajectory: list[tuple[float, SE2]], stamp: float) -> SE2:
    k = int(np.searchsorted(stamps, stamp))
    if k == 0 or stamps[k] == stamp:
        return trajectory[k][1]
    ratio = (stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
    return trajectory[k - 1][1].interpolate(trajectory[k][1], float(ratio))
