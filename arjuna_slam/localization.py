"""Localization on the map of a finished session: the robot moves, the map does not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.pose_graph import PoseGraph
from arjuna_slam.mapping.reference_map import ReferenceMap
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.deskew import motion_within
from arjuna_slam.matching.scan_filter import ScanFilter, Skip
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Tracker
from arjuna_slam.slam import SlamUpdate


class Localizer:
    """Finds the robot on a map. It keeps nothing of what it sees, so its memory does not grow.

    Args:
        config: The parameters.
        session: The session whose map it is.
        start: What is known of the robot's pose.
    """

    undone = 0

    def __init__(self, config: SlamConfig, session: Session, start: Start) -> None:
        self._config = config
        self._session = session
        self._reference = ReferenceMap(config, session)
        self._tracker = Tracker(config, ScanMatcher(config))
        self.scans = ScanFilter(config.max_laser_range)
        self._start: Start | None = start
        self._T_map_base = self._T_odom_base = self._T_odom_searched = IDENTITY
        self.graph = PoseGraph()
        self._stamp = -math.inf
        self._mapper = config.mapper()
        for scan, pose in zip(session.scans, session.poses, strict=True):
            self.graph.add_node(SE2.from_array(pose))
            self._mapper.add(scan)
        for edge in session.edges:
            self.graph.add_edge(edge)

    def process(self, scan: Scan, T_odom_base: SE2) -> SlamUpdate | None:
        """Take one scan.

        Args:
            scan: The scan, newer than the one before.
            T_odom_base: Odometry at the scan's stamp.

        Returns:
            The update, or None for a scan that cannot be used.
        """
        surface = self.scans.take(self._with_motion(scan, T_odom_base))
        if surface is None:
            return None
        match = (
            self._begin(surface) if self._start is not None else self._go_on(surface, T_odom_base)
        )
        if match is None:
            return None
        if self._start is not None or self._due(T_odom_base):
            self._T_odom_searched = T_odom_base
        self._start = None
        self._T_map_base, self._T_odom_base = match.T_field_base, T_odom_base
        self._stamp = scan.stamp
        return self._update(match)

    def restart(self, start: Start) -> None:
        """Look for the robot elsewhere.

        Args:
            start: What is known of its pose.
        """
        self._start = start

    def map(self, most_moved: int | None = None) -> OccupancyGrid | None:
        """Return the map.

        Args:
            most_moved: Means nothing here: no keyframe moves.
        """
        return self._mapper.grid(self.graph.poses, most_moved)

    @property
    def map_behind(self) -> bool:
        """Whether the map would be another than when it was last returned."""
        return self._mapper.behind(self.graph.poses)

    def session(self) -> Session:
        """Return the session whose map it is."""
        return self._session

    def optimize(self) -> None:
        """Do nothing: the map stays as it is."""

    def close_by_hand(self, moved: Mapping[int, SE2]) -> int:
        """Move nothing: the map stays as it is.

        Args:
            moved: Keyframes and where they were put in map.
        """
        return 0

    @property
    def skipped(self) -> int:
        """How many scans could not be used."""
        return self.scans.skipped

    def _begin(self, surface: Surface) -> Match | None:
        assert self._start is not None
        match = self._reference.find(surface, self._start)
        if match.status is MatchStatus.MATCHED or self._start.kind is not StartKind.ANYWHERE:
            return match
        self.scans.skip(Skip.LOST)
        return None

    def _with_motion(self, scan: Scan, T_odom_base: SE2) -> Scan:
        """Return the scan with the motion during it, as the odometry has it."""
        if scan.time_increment == 0.0 or self._start is not None:
            return scan
        delta = self._T_odom_base.inverse() @ T_odom_base
        return replace(scan, motion=motion_within(scan, delta, scan.stamp - self._stamp))

    def _go_on(self, surface: Surface, T_odom_base: SE2) -> Match:
        delta = self._T_odom_base.inverse() @ T_odom_base
        return self._tracker.locate(
            self._reference.field,
            surface,
            self._T_map_base @ delta,
            invert(self._config.odometry_covariance(delta)),
            self._due(T_odom_base),
        )

    def _due(self, T_odom_base: SE2) -> bool:
        return self._config.keyframe_due(self._T_odom_searched.inverse() @ T_odom_base)

    def _update(self, match: Match) -> SlamUpdate:
        return SlamUpdate(
            self._T_map_base,
            self._T_map_base @ self._T_odom_base.inverse(),
            match.covariance,
            False,
            0,
            match.status,
            0,
            self.graph.pose(0).inverse() @ self._T_map_base,
        )
