"""Replay: the filter fed from a log, as the node feeds it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.estimate import Status
from arjuna_slam.amcl.filter import ParticleFilter


@dataclass(frozen=True)
class Fix:
    """Where the filter said the robot was when a scan was taken.

    Attributes:
        stamp: [s].
        T_map_base: Pose of the base in the map.
        quality: Trust, 0..1.
        status: How the last update ended.
    """

    stamp: float
    T_map_base: SE2
    quality: float
    status: Status


def replay(belief: ParticleFilter, log: Iterable[tuple[Scan, SE2]]) -> list[Fix]:
    """Return a fix for each scan from the first estimate on.

    Args:
        belief: A filter with an initial pose, or globalized.
        log: Scans with the odometry at their stamps.

    Raises:
        LocalizationError: An odometry pose is not finite.
    """
    fixes: list[Fix] = []
    estimate = None
    for scan, T_odom_base in log:
        estimate = belief.update(T_odom_base, scan) or estimate
        if estimate is not None:
            pose = estimate.T_map_odom @ T_odom_base
            fixes.append(Fix(scan.stamp, pose, estimate.quality, estimate.status))
    return fixes
