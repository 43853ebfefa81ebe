"""The map of a finished session as one field, and where a scan lies in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.config import angle_param, length_param, share_param
from arjuna_core.se2 import SE2
from arjuna_slam.graph.candidates import LoopConfig
from arjuna_slam.graph.submap import SubmapConfig
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.correlative import Window, search
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface, extract

_DEPTH_MIN, _DEPTH_MAX = 3, 7  # levels of the search everywhere: blocks of 8 to 128 cells


@dataclass(frozen=True)
class ReferenceConfig(SubmapConfig, LoopConfig, MatcherConfig):
    """Parameters of the search on a finished map."""

    start_search_distance: float = length_param(
        1.5, "How far from the pose given a start is searched.", minimum=0.1, maximum=50.0
    )
    start_search_angle: float = angle_param(
        0.6, "How far from the heading given.", minimum=0.01, maximum=3.15
    )
    start_anywhere_response: float = share_param(0.7, "Mean likelihood for a start anywhere.")


class ReferenceMap:
    """A field of all keyframes of a session at their optimised poses, in map's frame."""

    def __init__(self, config: ReferenceConfig, session: Session) -> None:
        self._config = config
        self._matcher = ScanMatcher(config)
        self._first = SE2.from_array(session.poses[0])
        self.field = config.field()
        for scan, row in zip(session.scans, session.poses, strict=True):
            pose = SE2.from_array(row)
            points, normals = extract(scan, config.max_laser_range).dense(config.field_resolution)
            self.field.add(pose.apply(points), SE2(0.0, 0.0, pose.theta).apply(normals))
        self.field.trim()

    def find(self, surface: Surface, start: Start) -> Match:
        """Return where a scan lies on the map; where it fits nowhere, the start's pose."""
        if start.kind is StartKind.ANYWHERE:
            return self._search_all(surface)
        prior = self._first if start.kind is StartKind.FIRST_NODE else start.T_map_base
        c = self._config
        depth = 4  # levels of the search: blocks of 16 cells
        window = Window(c.start_search_distance, c.start_search_angle, depth)
        least = c.loop_match_minimum_response_coarse
        return self._matcher.match(self.field, surface, prior, window, least)

    def _search_all(self, surface: Surface) -> Match:
        rows, columns = self.field.score.shape
        half = 0.5 * self.field.resolution * np.array([columns, rows])
        centre = self.field.origin + half
        depth = round(math.log2(float(half.max()) / self.field.resolution)) - 2
        window = Window(float(half.max()), math.pi, min(max(depth, _DEPTH_MIN), _DEPTH_MAX))
        prior = SE2(float(centre[0]), float(centre[1]), 0.0)
        most = 120  # points of a scan, as it is searched everywhere
        points = surface.points[:: math.ceil(len(surface) / most)]
        found = search(self.field, points, prior, window, self._config.start_anywhere_response)
        if found is None:
            return Match(MatchStatus.LOW_RESPONSE, prior, np.eye(3), 0.0)
        match = self._matcher.track(self.field, surface, found[0])
        if match.response < self._config.loop_match_minimum_response_fine:
            return Match(MatchStatus.LOW_RESPONSE, prior, np.eye(3), match.response)
        return match
