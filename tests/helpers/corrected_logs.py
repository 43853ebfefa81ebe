"""Real logs with made-up drift: what a log's scans saw, from where, and odometry that errs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_slam import offline
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.slam import Slam
from tests.helpers.building_drives import Drift, DriftingOdometry, Drive

_SPACING, _TURN = 1.0, 0.6  # between two scans [m, rad]


def corrected(path: Path, *, as_is: bool) -> list[tuple[Scan, SE2]]:
    """Return a log's scans and where each was taken.

    Args:
        path: The log.
        as_is: Whether its poses are corrected already; else it is mapped, and what comes out of
            that is taken for the truth.
    """
    log = list(open_log(path, RecordingTopics()))
    if as_is:
        return log
    scans = {scan.stamp: scan for scan, _ in log}
    return [(scans[stamp], pose) for stamp, pose in offline.run(Slam(), log)]


def thinned(places: Sequence[tuple[Scan, SE2]]) -> list[tuple[Scan, SE2]]:
    """Return scans a metre or 0.6 rad apart, numbered by their stamps."""
    result: list[tuple[Scan, SE2]] = []
    for scan, pose in places:
        gap = result[-1][1].inverse() @ pose if result else None
        if gap is None or math.hypot(gap.x, gap.y) >= _SPACING or abs(wrap(gap.theta)) >= _TURN:
            result.append((replace(scan, stamp=float(len(result))), pose))
    return result


def drifting(places: Sequence[tuple[Scan, SE2]], seed: int, drift: Drift) -> Drive:
    """Return a log with odometry that drifts.

    Args:
        places: Scans and where they were taken.
        seed: Of the drift.
        drift: How the odometry errs.
    """
    error = DriftingOdometry(drift, np.random.default_rng([seed, 4]))
    result, odometry, before = [], SE2(), places[0][1]
    for scan, pose in places:
        odometry = odometry @ error.measured(before.inverse() @ pose)
        before = pose
        result.append((scan, odometry, pose))
    return result
