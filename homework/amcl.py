"""Judges of `amcl`."""

from typing import Any

import numpy as np

from bringup.demo.measures import rmse
from bringup.homework.exercise import Mark


def finds(attempt: Any) -> Mark:
    """Judge when it has found the robot, for good."""
    table = attempt.samples.table
    off = np.hypot(*(table[:, 4:6] - table[:, 1:3]).T)
    wrong = np.flatnonzero(~(off < 0.15))
    last = attempt.path[wrong[-1], 0] if len(wrong) else 0.0
    return Mark.of(last, 8.0, 20.0, "it was not within 0.15 m of the truth until {} s")


def position(attempt: Any) -> Mark:
    """Judge the error of the second half."""
    return Mark.of(_errors(attempt)[0], 0.08, 0.40, "it was {} m off")


def heading(attempt: Any) -> Mark:
    """Judge the heading's error of the second half."""
    return Mark.of(_errors(attempt)[1], 0.06, 0.40, "it was {} rad off")


def _errors(attempt: Any) -> tuple[float, float]:
    table = attempt.samples.table[len(attempt.samples.table) // 2 :]
    return rmse(table[:, 4:7], table[:, 1:4])
