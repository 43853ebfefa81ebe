"""Pose-graph SLAM: scans and odometry in, the robot's pose, a map and a trajectory out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.back_end import BackEnd
from arjuna_slam.config import SlamConfig
from arjuna_slam.loop_closure import LoopCloser
from arjuna_slam.mapper import Mapper
from arjuna_slam.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.submap import LocalMap
from arjuna_slam.surface import Surface, extract


@dataclass(frozen=True)
class SlamUpdate:
    """What one scan brought.

    Attributes:
        T_map_base: Robot in map.
        T_map_odom: Correction of the odometry.
        covariance: Of x, y, theta of the match, axes of map, `(3, 3) float64` [m^2, m rad, rad^2].
        keyframe: Whether the scan became a node.
        closures: Loop edges it brought.
        status: How the match ended; where it failed, the pose is the odometry's.
        node: The node of the trajectory that the pose hangs on.
        T_node_base: Robot in the frame of that node.
    """

    T_map_base: SE2
    T_map_odom: SE2
    covariance: NDArray[np.float64]
    keyframe: bool
    closures: int
    status: MatchStatus
    node: int
    T_node_base: SE2


class Slam:
    """Builds a map and the trajectory in it. The map's frame is the robot's pose at the first scan.

    Args:
        config: The parameters.
    """

    def __init__(self, config: SlamConfig | None = None) -> None:
        self._config = config or SlamConfig()
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next scan defines the map's frame."""
        config = self._config
        self.graph = PoseGraph()
        self.skipped = 0
        self._matcher = ScanMatcher(config)
        self._local = LocalMap(
            config.correlation_search_space_resolution,
            config.correlation_search_space_smear_deviation,
            config.submap_size,
        )
        self._closer = LoopCloser(config, self._matcher)
        self._mapper = Mapper(config.resolution, config.max_laser_range)
        self._stamps: list[float] = []
        self._T_anchor_base = IDENTITY
        self._T_odom_base = IDENTITY
        self._T_odom_keyframe = IDENTITY
        self._stamp = -math.inf
        self._travel = 0.0
        self._back_end = BackEnd(config, self.graph)

    def process(self, scan: Scan, T_odom_base: SE2) -> SlamUpdate | None:
        """Take one scan.

        Args:
            scan: The scan, newer than the one before.
            T_odom_base: Odometry at the scan's stamp.

        Returns:
            The update, or None for a scan that cannot be used (`skipped` counts them).
        """
        surface = self._usable(scan)
        if surface is None:
            self.skipped += 1
            return None
        if not self._stamps:
            return self._start(scan, surface, T_odom_base)
        prior, information = self._predict(T_odom_base)
        due = self._keyframe_due(T_odom_base)
        match = self._localize(surface, prior, information, due)
        self._T_anchor_base = match.T_field_base
        self._advance(scan.stamp, T_odom_base)
        closures = self._add_keyframe(scan, surface, match) if due else 0
        self._back_end.advance()
        return self._update(match, due, closures)

    def map(self) -> OccupancyGrid | None:
        """Return the map so far, or None before the first scan."""
        return self._mapper.grid(self.graph.poses)

    def trajectory(self) -> list[tuple[float, SE2]]:
        """Return stamp [s] and optimised pose in map of each keyframe."""
        return [(stamp, self.graph.pose(k)) for k, stamp in enumerate(self._stamps)]

    def optimize(self) -> None:
        """Optimise the graph now."""
        self._back_end.finish()

    @property
    def undone(self) -> int:
        """How many loop edges were taken back because the rest of the graph disagreed."""
        return self._back_end.undone

    def _usable(self, scan: Scan) -> Surface | None:
        """Return the scan's surface, or None if the scan is stale or has nothing in range."""
        if not math.isfinite(scan.stamp) or scan.stamp <= self._stamp:
            return None
        surface = extract(scan, self._config.max_laser_range)
        return surface if len(surface) > 0 else None

    def _start(self, scan: Scan, surface: Surface, T_odom_base: SE2) -> SlamUpdate:
        self._T_odom_base = self._T_odom_keyframe = T_odom_base
        self._advance(scan.stamp, T_odom_base)
        node = self._add_node(scan, IDENTITY)
        self._local.insert(node, surface, IDENTITY)
        self._closer.close(self.graph, node, 0.0, surface, [])
        return self._update(Match(MatchStatus.MATCHED, IDENTITY, np.zeros((3, 3)), 1.0), True, 0)

    def _predict(self, T_odom_base: SE2) -> tuple[SE2, NDArray[np.float64]]:
        """Return the pose that odometry predicts, in the reference's frame, and its information."""
        delta = self._T_odom_base.inverse() @ T_odom_base
        return self._T_anchor_base @ delta, invert(self._config.odometry_covariance(delta))

    def _keyframe_due(self, T_odom_base: SE2) -> bool:
        delta = self._T_odom_keyframe.inverse() @ T_odom_base
        config = self._config
        return (
            math.hypot(delta.x, delta.y) >= config.minimum_travel_distance
            or abs(wrap(delta.theta)) >= config.minimum_travel_heading
        )

    def _localize(
        self, surface: Surface, prior: SE2, information: NDArray[np.float64], search: bool
    ) -> Match:
        """Track the pose; at keyframes, and when tracking fails, also search for a better one."""
        reference = self._local.reference.field
        if not search:
            tracked = self._matcher.track(reference, surface, prior, information)
            if tracked.status in (MatchStatus.MATCHED, MatchStatus.TOO_FEW_POINTS):
                return tracked
        config = self._config
        return self._matcher.match(
            reference, surface, prior, config.window, config.match_minimum_response, information
        )

    def _advance(self, stamp: float, T_odom_base: SE2) -> None:
        self._travel += self._T_odom_base.distance(T_odom_base)
        self._T_odom_base = T_odom_base
        self._stamp = stamp

    def _add_node(self, scan: Scan, pose: SE2) -> int:
        self._stamps.append(scan.stamp)
        self._mapper.add(scan)
        return self.graph.add_node(pose)

    def _add_keyframe(self, scan: Scan, surface: Surface, match: Match) -> int:
        """Add a node with its edges, extend the submaps, close loops; return the closures."""
        previous = len(self.graph) - 1
        T_map_anchor = self.graph.pose(self._local.reference.anchor)
        node = self._add_node(scan, T_map_anchor @ match.T_field_base)
        delta = self._T_odom_keyframe.inverse() @ self._T_odom_base
        information = invert(self._config.odometry_covariance(delta))
        self.graph.add_edge(Edge(previous, node, delta, information, EdgeKind.ODOMETRY))
        if match.status is MatchStatus.MATCHED:
            for anchor, pose in self._local.poses(match.T_field_base):
                self.graph.add_edge(Edge(anchor, node, pose, match.information, EdgeKind.MATCH))
        self._T_odom_keyframe = self._T_odom_base
        edges = self._closer.close(self.graph, node, self._travel, surface, self._local.finished)
        self._T_anchor_base = self._local.insert(node, surface, match.T_field_base)
        self._back_end.add(edges)
        return len(edges)

    def _update(self, match: Match, keyframe: bool, closures: int) -> SlamUpdate:
        anchor = self._local.reference.anchor
        node = len(self.graph) - 1
        T_map_base = self.graph.pose(anchor) @ self._T_anchor_base
        turn = SE2(0.0, 0.0, self.graph.pose(anchor).theta).matrix()
        return SlamUpdate(
            T_map_base,
            T_map_base @ self._T_odom_base.inverse(),
            turn @ match.covariance @ turn.T,
            keyframe,
            closures,
            match.status,
            node,
            self.graph.pose(node).inverse() @ T_map_base,
        )
