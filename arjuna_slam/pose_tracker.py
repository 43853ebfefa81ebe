"""The interface of mapping and of localization: which scans come in, poses and a map come out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamNodeConfig
from arjuna_slam.graph.pose_graph import PoseGraph
from arjuna_slam.mapping.keyframes import Keyframes
from arjuna_slam.mapping.session import Session
from arjuna_slam.matching.scan_filter import ScanFilter
from arjuna_slam.matching.scan_matcher import MatchStatus


@dataclass(frozen=True)
class SlamUpdate:
    """The result of one scan."""

    T_map_base: SE2  # robot in map
    T_map_odom: SE2  # correction of the odometry
    # of x, y, theta of the match, axes of map, `(3, 3) float64` [m^2, m rad, rad^2]
    covariance: Floats
    keyframe: bool  # whether the scan was kept, as a node or in the buffer
    closures: int  # loop edges it brought
    status: MatchStatus  # how the match ended; where it failed, the pose is the odometry's
    node: int  # the node of the trajectory that the pose is relative to
    T_node_base: SE2  # robot in the frame of that node

    @property
    def entropy(self) -> float | None:
        """Differential entropy of the pose, a normal distribution [nat]; None where it is exact.

        Source: Cover and Thomas, Elements of Information Theory, theorem 8.4.1.
        """
        sign, log_det = np.linalg.slogdet(self.covariance)
        if sign <= 0.0 or not np.isfinite(log_det):
            return None
        return float(0.5 * (3.0 * (1.0 + np.log(2.0 * np.pi)) + log_det))


class Pace:
    """Chooses the scans that are processed: by their number, their time and the robot's motion."""

    def __init__(self) -> None:
        self._count = 0
        self._taken: float | None = None
        self._T_odom_taken: SE2 | None = None

    def is_due(self, c: SlamNodeConfig, scan: Scan, T_odom_base: SE2) -> bool:
        """Return whether a scan is the one in so many, and late and far enough from the last."""
        self._count += 1
        if (self._count - 1) % max(c.throttle_scans, 1):
            return False
        since = c.minimum_time_interval if self._taken is None else scan.stamp - self._taken
        if 0.0 < since < c.minimum_time_interval:
            return False
        last = self._T_odom_taken
        near = last is not None and not c.keyframe_due(last.inverse() @ T_odom_base)
        if near and not c.process_between_keyframes:
            return False
        self._taken, self._T_odom_taken = scan.stamp, T_odom_base
        return True


class PoseTracker(Protocol):
    """Tracks the robot on a map of keyframes."""

    keyframes: Keyframes  # the keyframes
    scans: ScanFilter  # takes the scans in, and counts those that cannot be used

    def process(self, scan: Scan, T_odom_base: SE2) -> SlamUpdate | None:
        """Take a scan, newer than the one before, and the odometry at its stamp.

        Returns:
            The update, or None for a scan that cannot be used (`scans` counts them).
        """

    def session(self) -> Session | None:
        """Return what another session needs to continue, or None before the first scan."""

    @property
    def graph(self) -> PoseGraph:
        """The keyframes' poses and the measurements between them."""
        return self.keyframes.graph

    def map(self, most_moved: int | None = None) -> OccupancyGrid | None:
        """Return the map so far, or None before the first scan.

        At most `most_moved` keyframes that a closure has moved are traced again, to bound the time;
        the next maps continue. None for all.
        """
        return self.keyframes.map(most_moved)
