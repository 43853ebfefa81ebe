"""Where the scans of a log were, once all of it is mapped."""

from __future__ import annotations

import itertools

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.offline import run
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, drive


def errors(trajectory: list[tuple[float, SE2]], log: Log) -> Floats:
    """Return how far each scan's pose is from the true one [m]."""
    truth, origin = {scan.stamp: pose for scan, _, pose in log}, log[0][2]
    assert [stamp for stamp, _ in trajectory] == sorted(truth)
    return np.array([(origin @ pose).distance(truth[stamp]) for stamp, pose in trajectory])


def test_scans_of_keyframes_that_were_forgotten_stay_where_they_were() -> None:
    log, slam = drive(seed=2, laps=3.0), Slam(SlamConfig(lifelong=True))
    trajectory = run(slam, [(scan, odometry) for scan, odometry, _ in log])
    assert len(slam.graph) < 120  # of 189: it has forgotten
    assert errors(trajectory, log).max() < 0.02


def test_scans_that_are_not_due_are_where_odometry_has_them() -> None:
    log, count = drive(seed=2, laps=1.0), itertools.count()
    entries = [(scan, odometry) for scan, odometry, _ in log]
    trajectory = run(Slam(), entries, lambda scan, odometry: next(count) % 4 == 0)
    assert errors(trajectory, log).max() < 0.02
