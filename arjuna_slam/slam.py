"""Pose-graph SLAM: scans and odometry in, the robot's pose, a map and a trajectory out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.back_end import BackEnd
from arjuna_slam.graph.loops import LoopCloser
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.graph.submap import LocalMap, Submap
from arjuna_slam.mapping.keyframes import forget_submap
from arjuna_slam.mapping.reference_map import ReferenceMap
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import LastOdometry, ScanFilter, Skip
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface, extract
from arjuna_slam.matching.tracking import Tracker
from arjuna_slam.pose_tracker import PoseTracker, SlamUpdate

_VAGUE = np.diag([4.0, 4.0, 10.0])  # information of a start that no scan confirms: 0.5 m, 0.3 rad


class Forgotten(NamedTuple):
    """Keyframes that have gone, and with them the numbers of those that have not."""

    renumbered: Ints  # the new number of each, -1 for those gone, `(N,) int64`
    poses: Floats  # of each in map, `(N, 3) float64` [m, m, rad]


class Slam(PoseTracker):
    """Builds a map in the frame that odometry has at the first scan, and the trajectory in it.

    Attributes:
        forgotten: What the last scan made it forget; None for nothing.
    """

    def __init__(self, config: SlamConfig | None = None) -> None:
        self._config = config or SlamConfig()
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next scan defines the map's frame."""
        config = self._config
        self.scans = ScanFilter(config.max_laser_range)
        self._matcher = ScanMatcher(config)
        self._tracker = Tracker(config, self._matcher)
        self._local = LocalMap(config)
        self._loops = LoopCloser(config, self._matcher, config.max_laser_range)
        self._begin_graph()
        self._resumed: tuple[ReferenceMap, Start] | None = None
        self._odometry = LastOdometry()
        self._T_anchor_base = self._T_anchor_keyframe = self._T_odom_keyframe = IDENTITY
        self._travel = 0.0
        self.forgotten: Forgotten | None = None

    def _begin_graph(self, undone: int = 0) -> None:
        self.keyframes = self._config.keyframes()
        self._back_end = BackEnd(self._config, self.graph, undone)

    def process(self, scan: Scan, T_odom_base: SE2, motion: SE2 | None = None) -> SlamUpdate | None:
        """Take one scan, see `PoseTracker.process`.

        `motion` is odometry from the first beam to the last; None for that of the velocity since
        the scan before, where the scan has a time increment.
        """
        scan = self._odometry.with_motion(scan, T_odom_base, motion)
        surface, self.forgotten = self.scans.take(scan), None
        if surface is None:
            return None
        if not self._local.active:
            return self._start(scan, surface, T_odom_base)
        due = self._config.keyframe_due(self._T_odom_keyframe.inverse() @ T_odom_base)
        match = self._locate(surface, T_odom_base, due, self._odometry.gap(scan.stamp))
        self._T_anchor_base = match.T_field_base
        self._travel += self._odometry.T_odom_base.distance(T_odom_base)
        self._odometry.advance(scan.stamp, T_odom_base)
        closures = self._add_keyframe(scan, surface, match) if due else 0
        self._back_end.advance()
        if not self._back_end.running:
            self._compare_submaps(self._local.finished)
        return self._update(match, due, closures)

    def trajectory(self) -> list[tuple[float, SE2]]:
        """Return stamp [s] and optimised pose in map of each keyframe."""
        return [(scan.stamp, self.graph.pose(k)) for k, scan in enumerate(self.keyframes.scans)]

    def close_by_hand(self, moved: Mapping[int, SE2]) -> int:
        """Close loops where a person says so, then optimise the graph to the end.

        Returns:
            How many of the keyframes fit where they were put; the rest stay as they were.
        """
        closed = 0
        for node, pose in sorted(moved.items()):
            surface = extract(self.keyframes.scans[node], self._config.max_laser_range)
            edge = self._loops.close_by_hand(self.graph, node, pose, surface, self._local.finished)
            if edge is not None:
                self.graph.add_edge(edge)
                closed += 1
        self.optimize()
        return closed

    def _compare_submaps(self, submaps: list[Submap]) -> bool:
        """Do a piece of the work that waits; return whether there was any."""
        if not self._config.do_loop_closing:
            return False
        found = self._loops.step(self.graph, submaps, self.keyframes.scans)
        if found:
            self._back_end.add([closure.edge for closure in found])
        return found is not None

    def finish(self) -> None:
        """Do all the work that waits, also on what the log ends in, and optimise to the end."""
        self.optimize()
        while self._compare_submaps(self._local.finished + self._local.active):
            while self._back_end.running:
                self._back_end.advance()
        self.optimize()

    def optimize(self) -> None:
        """Optimise the graph now."""
        self._back_end.finish()

    @property
    def undone(self) -> int:
        """Number of loop edges that were taken back because the rest of the graph disagreed."""
        return self._back_end.undone

    def session(self) -> Session | None:
        """Return what another session needs to continue, or None before the first scan."""
        if len(self.graph) == 0:
            return None
        submaps = self._local.finished + self._local.active
        return Session(
            self.keyframes.scans,
            self.graph.poses.copy(),
            np.array(self.keyframes.travel),
            tuple(self.graph.edges),
            tuple(tuple(submap.nodes) for submap in submaps),
            self._T_odom_keyframe if self._local.active else None,
        )

    def resume(self, session: Session, start: Start) -> None:
        """Continue another session's graph; the next scan is placed on its map.

        Raises:
            ValueError: It shall continue by odometry, which the session does not know.
        """
        self.reset()
        if start.kind is StartKind.ODOMETRY:
            if session.T_odom_base is None:
                raise ValueError("the session does not know where odometry was")
            self._T_odom_keyframe = session.T_odom_base
        self.keyframes.adopt(session)
        surfaces = [extract(scan, self._config.max_laser_range) for scan in session.scans]
        poses = [SE2.from_array(pose) for pose in session.poses]
        for nodes in session.submaps:
            self._local.restore(nodes, surfaces, poses)
        self._travel = float(session.travel[-1])
        self._resumed = ReferenceMap(self._config, session), start

    def _start(self, scan: Scan, surface: Surface, T_odom_base: SE2) -> SlamUpdate | None:
        """Begin the local map: where odometry is, or where the scan lies on a session's map."""
        found = self._locate_first(surface, T_odom_base)
        if found is None:
            return None
        self._T_odom_keyframe = T_odom_base
        self._odometry.advance(scan.stamp, T_odom_base)
        nearest = self.keyframes.nearest(found.T_field_base) if len(self.graph) else None
        node = self.keyframes.add(scan, found.T_field_base, self._travel)
        if nearest is not None:
            matched = found.status is MatchStatus.MATCHED
            T_i_j = self.graph.pose(nearest).inverse() @ found.T_field_base
            information = found.information if matched else _VAGUE
            self.graph.add_edge(Edge(nearest, node, T_i_j, information, EdgeKind.MATCH))
        self._T_anchor_base = self._T_anchor_keyframe = self._local.insert(node, surface, IDENTITY)
        covariance = np.zeros((3, 3)) if nearest is None else found.covariance
        return self._update(Match(found.status, IDENTITY, covariance, found.response), True, 0)

    def _locate_first(self, surface: Surface, T_odom_base: SE2) -> Match | None:
        """Return where the first scan lies in map, or None if it has to be looked for further."""
        if self._resumed is None:
            return Match(MatchStatus.MATCHED, T_odom_base, np.zeros((3, 3)), 1.0)
        reference, start = self._resumed
        if start.kind is StartKind.ODOMETRY:
            self._resumed = None
            delta = self._T_odom_keyframe.inverse() @ T_odom_base
            last, information = self.graph.pose(len(self.graph) - 1), self._information(delta)
            return self._tracker.locate(reference.field, surface, last, delta, information, True)
        found = reference.find(surface, start)
        if found.status is not MatchStatus.MATCHED and start.kind is StartKind.ANYWHERE:
            self.scans.skip(Skip.LOST)
            return None
        self._resumed = None
        return found

    def _locate(self, surface: Surface, T_odom_base: SE2, search: bool, gap: float) -> Match:
        delta = self._odometry.motion_to(T_odom_base)
        return self._tracker.locate(
            self._local.reference.field,
            surface,
            self._T_anchor_base,
            delta,
            self._information(delta),
            search,
            gap,
        )

    def _information(self, delta: SE2) -> Floats:
        return invert(self._config.odometry_covariance(delta))

    def _add_keyframe(self, scan: Scan, surface: Surface, match: Match) -> int:
        """Add a node with its edges, extend the submaps, close loops; return the closures."""
        previous = len(self.graph) - 1
        T_map_anchor = self.graph.pose(self._local.reference.anchor)
        node = self.keyframes.add(scan, T_map_anchor @ match.T_field_base, self._travel)
        delta = self._T_odom_keyframe.inverse() @ self._odometry.T_odom_base
        delta = self._tracker.stretched(delta)
        information = self._information(delta)
        self.graph.add_edge(Edge(previous, node, delta, information, EdgeKind.ODOMETRY))
        if match.status is MatchStatus.MATCHED and self._config.use_scan_matching:
            for submap, pose in self._local.poses(match.T_field_base):
                past, T_past_node, unseen_since = submap.constraint_to(pose)
                T_past_field = T_past_node @ match.T_field_base.inverse()
                known = invert(match.covariance_in(T_past_field) + unseen_since)
                prior = self._information(T_past_node)
                self.graph.add_edge(Edge(past, node, T_past_node, known, EdgeKind.MATCH, prior))
        self._T_odom_keyframe = self._odometry.T_odom_base
        edges = self._loops.close(self.graph, self.keyframes.travel, surface, self._local.finished)
        unseen = match.unseen(information)
        self._T_anchor_base = self._local.insert(node, surface, match.T_field_base, unseen)
        self._T_anchor_keyframe = self._T_anchor_base
        self._back_end.add(edges)
        if self._config.lifelong:
            self._forget()
        return len(edges)

    def _forget(self) -> None:
        """Look at one submap, so that the time does not grow, and forget it if it is covered."""
        session, finished = self.session(), self._local.finished
        if session is None or not finished:
            return
        remaining = forget_submap(self._config, session, len(self.graph) % len(finished))
        if remaining is None:
            return
        pruned, index = remaining
        self.forgotten = Forgotten(index, session.poses)
        self._local.renumber(index)
        self._begin_graph(self._back_end.undone)
        self.keyframes.adopt(pruned)
        self._loops.renumber(index)

    def _update(self, match: Match, keyframe: bool, closures: int) -> SlamUpdate:
        anchor = self._local.reference.anchor
        node = len(self.graph) - 1
        T_map_base = self.graph.pose(anchor) @ self._T_anchor_base
        rotation = SE2(0.0, 0.0, self.graph.pose(anchor).theta).matrix()
        return SlamUpdate(
            T_map_base,
            T_map_base @ self._odometry.T_odom_base.inverse(),
            rotation @ match.covariance @ rotation.T,
            keyframe,
            closures,
            match.status,
            node,
            self._T_anchor_keyframe.inverse() @ self._T_anchor_base,
        )
