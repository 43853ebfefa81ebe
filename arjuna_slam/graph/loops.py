"""Loop closure: candidates, the match with each, and which closures are believed.

A new keyframe is matched with past submaps at once, where the graph knows their poses well. Loops
that drift has opened wide are closed by finished submaps, each searched in those of the past: all
of that is a queue of small pieces of work in a fixed order, one at a scan, the rest when a log
ends. A large correction is held until other closures agree with it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.candidates import LoopConfig, Search, near_keyframe, near_submap, of_submap
from arjuna_slam.graph.hypotheses import Closure, Hypotheses
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.submap_match import SubmapMatch, SubmapMatcher
from arjuna_slam.graph.uncertainty import chained
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_BY_HAND = Window(0.75, 0.35, 3)  # a hand in RViz is no better


@dataclass(frozen=True)
class _Task:
    query: int
    past: int
    covariance: Floats


class LoopCloser:
    """Finds loop edges for new keyframes, and closures of finished submaps."""

    def __init__(self, config: LoopConfig, matcher: ScanMatcher, range_max: float) -> None:
        self._config = config
        self._matcher = matcher
        self._submap_matcher = SubmapMatcher(config, matcher, range_max)
        self._tried: dict[int, float] = {}
        self._restart_submaps()

    def _restart_submaps(self) -> None:
        """Forget what was found of keyframes and submaps: they may be others now."""
        self._of_keyframes, self._of_submaps = Hypotheses(overlap=0), Hypotheses(overlap=1)
        self._work: Generator[None, None, list[Closure]] | None = None
        self._tasks: deque[_Task] = deque()
        self._next = 0
        self._searched: dict[tuple[int, int], tuple[SE2, float]] = {}
        self._closed: set[tuple[int, int]] = set()

    def renumber(self, index: Ints) -> None:
        """Go on with some of the keyframes: `index` has each one's new number, -1 if it is gone."""
        tried = self._tried.items()
        self._tried = {int(index[k]): travel for k, travel in tried if index[k] >= 0}
        self._restart_submaps()

    def close(
        self, graph: PoseGraph, travel: Sequence[float], surface: Surface, submaps: Sequence[Submap]
    ) -> list[Edge]:
        """Return the loop edges of a new keyframe, and those of earlier ones it confirms.

        The keyframe is the newest of those taken after so much travel each [m]; submaps are
        finished ones.
        """
        node, now = len(travel) - 1, travel[-1]
        if not self._config.do_loop_closing:
            return []
        edges: list[Edge] = []
        for submap, search in near_keyframe(self._config, graph, node, travel, submaps):
            anchor = submap.anchor
            if now - self._tried.get(anchor, -math.inf) < self._config.loop_retry_distance:
                continue
            match = self._match(submap, surface, search)
            by_drift = self._config.loop_search_by_drift
            fits = not by_drift or search.is_plausible(match.T_field_base)
            if match.status is not MatchStatus.MATCHED or not fits:
                self._tried[anchor] = now
                continue
            edges.extend(self._believe(graph, submap, node, match, search.prior))
        return edges

    def close_by_hand(
        self, graph: PoseGraph, node: int, pose: SE2, surface: Surface, submaps: Sequence[Submap]
    ) -> Edge | None:
        """Return the loop edge of a keyframe that a person has put at a pose in map, or None.

        Submaps that the keyframe is in are left out.
        """
        best: tuple[float, Edge] | None = None
        reach = self._config.loop_search_maximum_distance
        for submap in submaps:
            gaps = np.hypot(*(graph.poses[submap.nodes, :2] - (pose.x, pose.y)).T)
            if node in submap.nodes or gaps.min() > reach:
                continue
            prior = graph.pose(submap.anchor).inverse() @ pose
            least = self._config.loop_match_minimum_response_coarse
            match = self._matcher.match(submap.field, surface, prior, _BY_HAND, least)
            if match.status is MatchStatus.MATCHED and (best is None or match.response > best[0]):
                best = match.response, _edge_of_keyframe(submap, node, match)
        return None if best is None else best[1]

    def _match(self, submap: Submap, surface: Surface, search: Search) -> Match:
        c, narrow = self._config, 0.5  # [m] half a window that few levels search faster
        window = Window(search.xy, search.theta, 2 if search.xy < narrow else 4)
        least = c.loop_match_minimum_response_coarse
        match = self._matcher.match(submap.field, surface, search.prior, window, least)
        good = match.response >= c.loop_match_minimum_response_fine
        if match.status is MatchStatus.MATCHED and not good:
            low = MatchStatus.LOW_RESPONSE
            return Match(low, search.prior, match.covariance, match.response)
        return match

    def _believe(
        self, graph: PoseGraph, submap: Submap, node: int, match: Match, prior: SE2
    ) -> list[Edge]:
        """Return the edges to add: at once if the correction is small, else once two agree."""
        edge = _edge_of_keyframe(submap, node, match)
        change, c = prior.inverse() @ match.T_field_base, self._config
        near = math.hypot(change.x, change.y) < c.loop_sure_distance
        if near and abs(change.theta) < c.loop_sure_angle:
            return [edge]
        closure = Closure(node, 0, edge, weight=1.0, enough=2.0)
        return [one.edge for one in self._of_keyframes.add(graph, closure)]

    def step(
        self, graph: PoseGraph, submaps: Sequence[Submap], scans: Sequence[Scan]
    ) -> list[Closure] | None:
        """Do the next piece of work on finished submaps; the graph is not changed.

        Returns:
            Closures to be believed, or None where there is nothing to do.
        """
        if not self._config.loop_search_by_drift:
            return None
        if self._work is None and self._tasks:
            self._work = self._compare(self._tasks.popleft(), graph, submaps, scans)
        if self._work is not None:
            try:
                next(self._work)
            except StopIteration as done:
                self._work = None
                found: list[Closure] = done.value
                return found
            return []
        if self._next < len(submaps):
            self._look_around(self._next, graph, submaps)
            self._next += 1
            return []
        return None

    def _look_around(self, query: int, graph: PoseGraph, submaps: Sequence[Submap]) -> None:
        most = 8  # of a submap at a time
        found = [
            _Task(query, past, search.covariance)
            for _, past, search in near_submap(self._config, graph, query, submaps)
            if (query, past) not in self._closed and not self._is_searched(query, past, search)
        ]
        self._tasks.extend(found[:most])

    def _is_searched(self, query: int, past: int, search: Search) -> bool:
        """Return whether nearly all of a window has been searched already."""
        tried = self._searched.get((query, past))
        return tried is not None and tried[0].distance(search.prior) + 0.5 * search.xy < tried[1]

    def _compare(
        self, task: _Task, graph: PoseGraph, submaps: Sequence[Submap], scans: Sequence[Scan]
    ) -> Generator[None, None, list[Closure]]:
        """Compare two submaps; return the closures that are believed then."""
        query, past = submaps[task.query], submaps[task.past]
        search = of_submap(self._config, graph, query, past, task.covariance)
        self._searched[task.query, task.past] = search.prior, search.xy
        match = yield from self._submap_matcher.find(query, past, search, scans)
        if match is None:
            return []
        edge, wide = _edge_of_submap(query, past, match), self._config.loop_wide_area
        small = 0.3  # [m] correction up to which a closure needs no other in a narrow window
        far = bool(np.hypot(*graph.residual(edge)[:2]) > small)
        weight, enough = 1.0 if match.sure else 0.5, 2.0 if search.ambiguous or far else 0.5
        large = match.sure and match.area >= wide
        closure = Closure(task.query, task.past, edge, weight, enough, large)
        believed = self._of_submaps.add(graph, closure)
        self._closed.update((one.query, one.past) for one in believed)
        bends = 0.5  # [m] correction from which on all is searched again
        if any(np.hypot(*graph.residual(one.edge)[:2]) > bends for one in believed):
            self._next = 0
        return believed


def _edge_of_keyframe(submap: Submap, node: int, match: Match) -> Edge:
    """Return the edge that a match makes, with the keyframe that saw most of what was matched."""
    past, T_anchor_past = submap.nearest(match.T_field_base)
    T_past_anchor = T_anchor_past.inverse()
    known = doubted(match.covariance_in(T_past_anchor))
    bent = chained(T_past_anchor, submap.bend, match.T_field_base, np.zeros((3, 3)))
    information = invert(known + bent)
    return Edge(past, node, T_past_anchor @ match.T_field_base, information, EdgeKind.LOOP)


def _edge_of_submap(query: Submap, past: Submap, match: SubmapMatch) -> Edge:
    """Return the edge between the keyframes nearest to what holds the one in the other."""
    T = match.T_past_query
    at = [T @ pose for pose in query.poses]
    i, j = (_nearest(poses, match.holds) for poses in (past.poses, at))
    T_i_past = past.poses[i].inverse()
    covariance = chained(T_i_past, past.bend, T, match.covariance)
    covariance = chained(T_i_past @ T, covariance, query.poses[j], query.bend)
    return Edge(past.nodes[i], query.nodes[j], T_i_past @ at[j], invert(covariance), EdgeKind.LOOP)


def _nearest(poses: Sequence[SE2], point: Floats) -> int:
    return int(np.argmin([math.hypot(pose.x - point[0], pose.y - point[1]) for pose in poses]))


def doubted(covariance: Floats) -> Floats:
    """Return a match's covariance `(3, 3)`, enlarged along a direction that it hardly sees.

    A few points there are the corner of one thing, with one error, and no odometry contradicts it.
    """
    (narrow, wide), axes = np.linalg.eigh(covariance[:2, :2])
    hardly = 0.1  # share of the best seen direction's information
    seen = narrow / (hardly * wide)
    if seen >= 1.0:
        return covariance
    result: Floats = covariance.copy()
    result[:2, :2] += (seen**-2 - 1.0) * wide * np.outer(axes[:, 1], axes[:, 1])
    return result
