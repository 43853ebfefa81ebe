"""The interface of mapping and of localization on a saved graph: scans in, poses and a map out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
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
    keyframe: bool  # whether the scan became a node
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
