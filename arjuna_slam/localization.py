"""Localization on the map of a finished session: the robot moves, the session does not."""

from __future__ import annotations

from collections import deque

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.mapping.reference_map import ReferenceMap
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import LastOdometry, ScanFilter, Skip
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Tracker
from arjuna_slam.pose_tracker import PoseTracker, SlamUpdate


class Localizer(PoseTracker):
    """Finds the robot on a map.

    Of what it sees it keeps the last `scan_buffer_size` keyframes, so its memory does not grow:
    they are matched with where the map does not fit, and shown in it.
    """

    def __init__(self, config: SlamConfig, session: Session, start: Start) -> None:
        self._config = config
        self._session = session
        self._reference = ReferenceMap(config, session)
        self._tracker = Tracker(config, ScanMatcher(config))
        self.scans = ScanFilter(config.max_laser_range)
        self.keyframes = config.keyframes()
        self.keyframes.adopt(session)
        self._start: Start | None = start
        self._odometry = LastOdometry()
        self._T_map_base = self._T_odom_searched = IDENTITY
        self._buffer: deque[tuple[Scan, SE2, Surface]] = deque(maxlen=config.scan_buffer_size)
        self._recent = config.field()

    def process(self, scan: Scan, T_odom_base: SE2) -> SlamUpdate | None:
        """Take one scan; see `PoseTracker.process`."""
        surface = self.scans.take(self._odometry.with_motion(scan, T_odom_base))
        if surface is None:
            return None
        search = self._start is not None or self._search_due(T_odom_base)
        match = self._locate(surface, T_odom_base, search)
        if match is None:
            return None
        if search:
            self._T_odom_searched = T_odom_base
        self._start = None
        self._T_map_base = match.T_field_base
        self._odometry.advance(scan.stamp, T_odom_base)
        kept = search and self._buffer.maxlen != 0
        if kept:
            self._buffer.append((scan, self._T_map_base, surface))
            self._look_back()
        return self._update(match, kept)

    def restart(self, start: Start) -> None:
        """Search the robot again; `start` is what is known of its pose."""
        self._start = start
        self.clear_buffer()

    def clear_buffer(self) -> None:
        """Forget the keyframes seen."""
        self._buffer.clear()

    def map(self, most_moved: int | None = None) -> OccupancyGrid | None:
        """Return the session's map, with the keyframes seen in it."""
        return self.keyframes.map(most_moved, ((scan, pose) for scan, pose, _ in self._buffer))

    def _look_back(self) -> None:
        """Make the field of the keyframes seen."""
        self._recent = self._config.field()
        for _, pose, surface in self._buffer:
            points, normals = surface.dense(self._config.field_resolution)
            self._recent.add(pose.apply(points), SE2(0.0, 0.0, pose.theta).apply(normals))

    def session(self) -> Session:
        """Return the session whose map it is."""
        return self._session

    def _locate(self, surface: Surface, T_odom_base: SE2, search: bool) -> Match | None:
        """Return where a scan lies on the map, or None if it has to be looked for further."""
        if self._start is None:
            delta = self._odometry.motion_to(T_odom_base)
            information = invert(self._config.odometry_covariance(delta))
            fields = [self._reference.field, *([self._recent] if self._buffer else [])]
            for field in fields:
                match = self._tracker.locate(
                    field, surface, self._T_map_base, delta, information, search
                )
                if match.status is MatchStatus.MATCHED:
                    break
            return match
        match = self._reference.find(surface, self._start)
        if match.status is MatchStatus.MATCHED or self._start.kind is not StartKind.ANYWHERE:
            return match
        self.scans.skip(Skip.LOST)
        return None

    def _search_due(self, T_odom_base: SE2) -> bool:
        return self._config.keyframe_due(self._T_odom_searched.inverse() @ T_odom_base)

    def _update(self, match: Match, kept: bool) -> SlamUpdate:
        return SlamUpdate(
            self._T_map_base,
            self._T_map_base @ self._odometry.T_odom_base.inverse(),
            match.covariance,
            kept,
            0,
            match.status,
            0,
            self.graph.pose(0).inverse() @ self._T_map_base,
        )
