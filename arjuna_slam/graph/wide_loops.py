"""Loops that drift has opened wide: each finished submap against each past one it may overlap.

The graph says how far drift may have come, so that is how wide a search is. All of it is a queue of
small pieces of work in a fixed order: one at a scan, the rest when a log ends. What is found is
held until several closures agree, and all is searched again once they have bent the graph.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.hypotheses import Closure, Hypotheses
from arjuna_slam.graph.loops import LoopConfig, Submap
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap_match import Search, SubmapMatch, SubmapMatcher
from arjuna_slam.graph.uncertainty import chained, relative_covariances, spread
from arjuna_slam.matching.scan_matcher import ScanMatcher, invert

_OVERLAP = 3.0  # how near two submaps' trajectories must come [m]
_SMALL = 0.3  # correction up to which a closure needs no other in a narrow window [m]
_SURE, _UNSURE = 1.0, 0.5  # weight of a closure, and of one that fits elsewhere as well
_AREA = 12.0  # of walls that hold a submap from which on they are no mere door [m^2]
_BELIEVED = 2.0  # weights of closures that agree


@dataclass(frozen=True)
class _Task:
    query: int
    past: int
    covariance: Floats


class WideLoops:
    """Closes wide loops, a piece of work at a time."""

    def __init__(self, config: LoopConfig, matcher: ScanMatcher, range_max: float) -> None:
        self._config = config
        self._matcher = SubmapMatcher(config, matcher, range_max)
        self.restart()

    def restart(self) -> None:
        """Forget all; the submaps may be others now."""
        self._work: Generator[None, None, list[Closure]] | None = None
        self._tasks: deque[_Task] = deque()
        self._next = 0
        self._tried: dict[tuple[int, int], tuple[SE2, float]] = {}
        self._closed: set[tuple[int, int]] = set()
        self._hypotheses = Hypotheses()

    def step(
        self, graph: PoseGraph, submaps: Sequence[Submap], scans: Sequence[Scan]
    ) -> list[Closure] | None:
        """Do the next piece of work; the graph is not changed.

        Returns:
            Closures to be believed, or None where there is nothing to do.
        """
        if self._work is None and self._tasks:
            self._work = self._try(self._tasks.popleft(), graph, submaps, scans)
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
        """Note the past submaps that one may lie on, the nearest first."""
        covariances = relative_covariances(graph, submaps[query].anchor)
        gaps, joined = _gaps(graph, submaps[query].nodes), _joined(graph, submaps[query].nodes)
        found: list[tuple[float, _Task]] = []
        known_below = 0.3  # [m] deviation at which joined submaps need no comparison
        for past in self._within_reach(gaps, submaps[: max(query - 1, 0)]):
            task = _Task(query, past, covariances[submaps[past].anchor])
            known = spread(task.covariance)[0] < known_below and joined[submaps[past].nodes].any()
            if known or (query, past) in self._closed:
                continue
            gap = float(gaps[submaps[past].nodes].min())
            window = self._window(task, graph, submaps)
            if gap < _OVERLAP + window.xy and not self._is_searched(task, window):
                found.append((gap, task))
        found.sort(key=lambda entry: (entry[0], entry[1].past))
        most = 8  # of a submap at a time
        self._tasks.extend(task for _, task in found[:most])

    def _within_reach(self, gaps: Floats, submaps: Sequence[Submap]) -> Sequence[int]:
        """Return which submaps the widest window may reach, by their anchors alone."""
        widest = _OVERLAP + 0.5 * self._config.loop_search_space_dimension
        anchors = np.array([submap.anchor for submap in submaps], np.intp)
        lengths = np.array([submap.path_length for submap in submaps])
        longer = 1.5  # as a path may be longer in the graph
        near: list[int] = np.flatnonzero(gaps[anchors] < widest + longer * lengths).tolist()
        return near

    def _window(self, task: _Task, graph: PoseGraph, submaps: Sequence[Submap]) -> Search:
        c, (xy, theta) = self._config, spread(task.covariance)
        past, query = (graph.pose(submaps[k].anchor) for k in (task.past, task.query))
        half = min(0.2 + c.loop_search_deviations * xy, 0.5 * c.loop_search_space_dimension)
        angle = min(0.03 + c.loop_search_deviations * theta, c.loop_search_angle)
        return Search(past.inverse() @ query, task.covariance, half, angle)

    def _is_searched(self, task: _Task, window: Search) -> bool:
        """Return whether nearly all of a window has been searched already."""
        tried = self._tried.get((task.query, task.past))
        return tried is not None and tried[0].distance(window.prior) + 0.5 * window.xy < tried[1]

    def _try(
        self, task: _Task, graph: PoseGraph, submaps: Sequence[Submap], scans: Sequence[Scan]
    ) -> Generator[None, None, list[Closure]]:
        """Compare two submaps; return the closures that are believed then."""
        query, past = submaps[task.query], submaps[task.past]
        window = self._window(task, graph, submaps)
        self._tried[task.query, task.past] = window.prior, window.xy
        match = yield from self._matcher.find(query, past, window, scans)
        if match is None:
            return []
        edge = _edge(query, past, match)
        far = bool(np.hypot(*graph.residual(edge)[:2]) > _SMALL)
        enough = _BELIEVED if window.ambiguous or far else _UNSURE
        weight, wide = _SURE if match.sure else _UNSURE, match.sure and match.area >= _AREA
        closure = Closure(task.query, task.past, edge, weight, enough, wide)
        believed = self._hypotheses.add(graph, closure)
        self._closed.update((one.query, one.past) for one in believed)
        bends = 0.5  # [m] correction from which on all is searched again
        if any(np.hypot(*graph.residual(one.edge)[:2]) > bends for one in believed):
            self._next = 0
        return believed


def _joined(graph: PoseGraph, nodes: list[int]) -> Bools:
    """Return which nodes a loop edge joins to some, `(N,) bool`."""
    table = graph.table
    own = np.zeros(len(graph), np.bool_)
    own[nodes] = True
    joined = np.zeros(len(graph), np.bool_)
    joined[table.i[table.loop & own[table.j]]] = True
    joined[table.j[table.loop & own[table.i]]] = True
    return joined


def _gaps(graph: PoseGraph, nodes: list[int]) -> Floats:
    """Return how far each node is from the nearest of some, `(N,) float64` [m]."""
    own = graph.poses[nodes[:: max(1, len(nodes) // 6)], :2]
    gaps: Floats = np.hypot(*(graph.poses[:, None, :2] - own[None]).transpose(2, 0, 1)).min(axis=1)
    return gaps


def _edge(query: Submap, past: Submap, match: SubmapMatch) -> Edge:
    """Return the edge between the keyframes nearest to what holds the one in the other."""
    T = match.T_past_query
    at = [T @ pose for pose in query.poses]
    i, j = (_nearest(poses, match.holds) for poses in (past.poses, at))
    T_i_past = past.poses[i].inverse()
    covariance = chained(T_i_past, past.bend, T, match.covariance)
    covariance = chained(T_i_past @ T, covariance, query.poses[j], query.bend)
    T_i_j = T_i_past @ at[j]
    return Edge(past.nodes[i], query.nodes[j], T_i_j, invert(covariance), EdgeKind.LOOP)


def _nearest(poses: Sequence[SE2], point: Floats) -> int:
    """Return which of some poses is nearest to a point."""
    return int(np.argmin([math.hypot(pose.x - point[0], pose.y - point[1]) for pose in poses]))
