"""Pose-graph SLAM: scans and odometry in, the robot's pose, a map and a trajectory out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.back_end import BackEnd
from arjuna_slam.graph.loops import LoopCloser
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.mapping.lifelong import is_redundant, prune
from arjuna_slam.mapping.reference_map import ReferenceMap
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.mapping.submap import LocalMap
from arjuna_slam.matching.deskew import motion_within
from arjuna_slam.matching.scan_filter import ScanFilter, Skip
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface, extract
from arjuna_slam.matching.tracking import Tracker

_AT_START = Match(MatchStatus.MATCHED, IDENTITY, np.zeros((3, 3)), 1.0)
_VAGUE = np.diag([4.0, 4.0, 10.0])  # information of a start that no scan confirms: 0.5 m, 0.3 rad


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
        self.scans = ScanFilter(config.max_laser_range)
        self._resumed: tuple[ReferenceMap, Start] | None = None
        self._matcher = ScanMatcher(config)
        self._tracker = Tracker(config, self._matcher)
        self._local = LocalMap(
            config.field_resolution,
            config.field_deviation,
            config.submap_size,
        )
        self._closer = LoopCloser(config, self._matcher)
        self._begin_graph()
        self._T_anchor_base = IDENTITY
        self._T_odom_base = IDENTITY
        self._T_odom_keyframe = IDENTITY
        self._stamp = -math.inf
        self._travel = 0.0

    def _begin_graph(self) -> None:
        """Start without keyframes."""
        config = self._config
        self.graph = PoseGraph()
        self._mapper = config.mapper()
        self._stamps: list[float] = []
        self._back_end = BackEnd(config, self.graph)

    def process(self, scan: Scan, T_odom_base: SE2, motion: SE2 | None = None) -> SlamUpdate | None:
        """Take one scan.

        Args:
            scan: The scan, newer than the one before.
            T_odom_base: Odometry at the scan's stamp.
            motion: Odometry from the first beam to the last; None for that of the velocity since
                the scan before, where the scan has a time increment.

        Returns:
            The update, or None for a scan that cannot be used (`skipped` counts them).
        """
        scan = self._with_motion(scan, T_odom_base, motion)
        surface = self.scans.take(scan)
        if surface is None:
            return None
        if not self._local.active:
            return self._start(scan, surface, T_odom_base)
        prior, information = self._predict(T_odom_base)
        due = self._config.keyframe_due(self._T_odom_keyframe.inverse() @ T_odom_base)
        reference = self._local.reference.field
        match = self._tracker.locate(reference, surface, prior, information, due)
        self._T_anchor_base = match.T_field_base
        self._advance(scan.stamp, T_odom_base)
        closures = self._add_keyframe(scan, surface, match) if due else 0
        self._back_end.advance()
        return self._update(match, due, closures)

    def map(self, most_moved: int | None = None) -> OccupancyGrid | None:
        """Return the map so far, or None before the first scan.

        Args:
            most_moved: How many keyframes that a closure has moved are traced anew at most, to
                bound the time it takes; the next maps go on. None for all.
        """
        return self._mapper.grid(self.graph.poses, most_moved)

    @property
    def map_behind(self) -> bool:
        """Whether the map would be another than when it was last returned."""
        return self._mapper.behind(self.graph.poses)

    def trajectory(self) -> list[tuple[float, SE2]]:
        """Return stamp [s] and optimised pose in map of each keyframe."""
        return [(stamp, self.graph.pose(k)) for k, stamp in enumerate(self._stamps)]

    def close_by_hand(self, moved: Mapping[int, SE2]) -> int:
        """Close loops where a person says so, then optimise the graph to the end.

        Args:
            moved: Keyframes and where they were put in map.

        Returns:
            How many of them fit where they were put; the rest stay as they were.
        """
        closed = 0
        for node, pose in sorted(moved.items()):
            surface = extract(self._mapper.scans[node], self._config.max_laser_range)
            edge = self._closer.close_by_hand(self.graph, node, pose, surface, self._local.finished)
            if edge is not None:
                self.graph.add_edge(edge)
                closed += 1
        self.optimize()
        return closed

    def optimize(self) -> None:
        """Optimise the graph now."""
        self._back_end.finish()

    @property
    def skipped(self) -> int:
        """How many scans could not be used."""
        return self.scans.skipped

    @property
    def undone(self) -> int:
        """How many loop edges were taken back because the rest of the graph disagreed."""
        return self._back_end.undone

    def session(self) -> Session | None:
        """Return what another session needs to go on, or None before the first scan."""
        if not self._stamps:
            return None
        submaps = self._local.finished + self._local.active
        return Session(
            self._mapper.scans,
            self.graph.poses.copy(),
            np.array(self._closer.travel),
            tuple(self.graph.edges),
            tuple(tuple(submap.nodes) for submap in submaps),
        )

    def resume(self, session: Session, start: Start) -> None:
        """Go on from another session's graph; the next scan is placed on its map.

        Args:
            session: The session.
            start: What is known of the robot's pose.
        """
        self.reset()
        self._adopt(session)
        surfaces = [extract(scan, self._config.max_laser_range) for scan in session.scans]
        poses = [SE2.from_array(pose) for pose in session.poses]
        for nodes in session.submaps:
            self._local.restore(nodes, surfaces, poses)
        self._travel = float(session.travel[-1])
        self._resumed = ReferenceMap(self._config, session), start

    def _adopt(self, session: Session, index: NDArray[np.int64] | None = None) -> None:
        """Take over a session's keyframes and edges."""
        for scan, pose in zip(session.scans, session.poses, strict=True):
            self._add_node(scan, SE2.from_array(pose))
        for edge in session.edges:
            self.graph.add_edge(edge)
        self._closer.resume(session.travel, index)

    def _start(self, scan: Scan, surface: Surface, T_odom_base: SE2) -> SlamUpdate | None:
        """Begin the local map: at the map's origin, or where the scan lies on a session's map."""
        found = self._place(surface)
        if found is None:
            return None
        self._T_odom_base = self._T_odom_keyframe = T_odom_base
        self._stamp = scan.stamp
        nearest = self._nearest(found.T_field_base)
        node = self._add_node(scan, found.T_field_base)
        if nearest is not None:
            matched = found.status is MatchStatus.MATCHED
            T_i_j = self.graph.pose(nearest).inverse() @ found.T_field_base
            information = found.information if matched else _VAGUE
            self.graph.add_edge(Edge(nearest, node, T_i_j, information, EdgeKind.MATCH))
        self._T_anchor_base = self._local.insert(node, surface, IDENTITY)
        self._closer.close(self.graph, node, self._travel, surface, [])
        covariance = np.zeros((3, 3)) if nearest is None else found.covariance
        return self._update(Match(found.status, IDENTITY, covariance, found.response), True, 0)

    def _place(self, surface: Surface) -> Match | None:
        """Return where the first scan lies in map, or None if it has to be looked for further."""
        if self._resumed is None:
            return _AT_START
        reference, start = self._resumed
        found = reference.find(surface, start)
        if found.status is not MatchStatus.MATCHED and start.kind is StartKind.ANYWHERE:
            self.scans.skip(Skip.LOST)
            return None
        self._resumed = None
        return found

    def _nearest(self, pose: SE2) -> int | None:
        """Return the keyframe nearest to a pose in map."""
        if len(self.graph) == 0:
            return None
        return int(np.hypot(*(self.graph.poses[:, :2] - (pose.x, pose.y)).T).argmin())

    def _predict(self, T_odom_base: SE2) -> tuple[SE2, NDArray[np.float64]]:
        """Return the pose that odometry predicts, in the reference's frame, and its information."""
        delta = self._T_odom_base.inverse() @ T_odom_base
        return self._T_anchor_base @ delta, invert(self._config.odometry_covariance(delta))

    def _with_motion(self, scan: Scan, T_odom_base: SE2, motion: SE2 | None) -> Scan:
        """Return the scan with the motion during it."""
        if motion is None and scan.time_increment != 0.0 and self._local.active:
            delta = self._T_odom_base.inverse() @ T_odom_base
            motion = motion_within(scan, delta, scan.stamp - self._stamp)
        return scan if motion is None else replace(scan, motion=motion)

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
        if match.status is MatchStatus.MATCHED and self._config.use_scan_matching:
            for anchor, pose in self._local.poses(match.T_field_base):
                self.graph.add_edge(Edge(anchor, node, pose, match.information, EdgeKind.MATCH))
        self._T_odom_keyframe = self._T_odom_base
        edges = self._closer.close(self.graph, node, self._travel, surface, self._local.finished)
        self._T_anchor_base = self._local.insert(node, surface, match.T_field_base)
        self._back_end.add(edges)
        if self._config.lifelong:
            self._forget()
        return len(edges)

    def _forget(self) -> None:
        """Forget a submap that newer keyframes cover, with the keyframes that only it has.

        One submap is looked at for each keyframe, so that the time that takes does not grow.
        """
        if not self._local.finished:
            return
        found = len(self.graph) % len(self._local.finished)
        session = self.session()
        if session is None or not is_redundant(session.poses, session.submaps[found]):
            return
        others = {node for k, nodes in enumerate(session.submaps) if k != found for node in nodes}
        keep = np.array([k in others for k in range(len(self.graph))])
        keep[session.submaps[found][0]] = False  # the anchor goes, and with it the submap
        pruned, index = prune(session, keep)
        self._local.renumber(index)
        undone = self._back_end.undone
        self._begin_graph()
        self._back_end.undone = undone
        self._adopt(pruned, index)

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
