"""Drives whose loops are to be closed, and matchers that answer as scripted."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.candidates import Search
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.submap_match import SubmapMatch
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface

NOTHING = Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.bool_))
GOOD = np.diag([0.01**2, 0.01**2, 0.005**2])
SIDE = 20  # keyframes of a side of the square that is driven, a metre apart
LAST = 4 * SIDE - 1


@dataclass
class Scripted(ScanMatcher):
    """A matcher that finds something off the prior, and keeps where it was asked to search."""

    off: SE2 = IDENTITY
    response: float = 0.9
    status: MatchStatus = MatchStatus.MATCHED
    known: Floats = field(default_factory=GOOD.copy)
    asked: list[tuple[Field, SE2, Window, float]] = field(default_factory=list)

    def match(
        self,
        field: Field,
        surface: Surface,
        prior: SE2,
        window: Window,
        least: float,
        information: Floats = GOOD,
    ) -> Match:
        self.asked.append((field, prior, window, least))
        return Match(self.status, prior @ self.off, self.known, self.response)


@dataclass
class ScriptedSubmaps:
    """A matcher of submaps that keeps which anchors it is asked of, and answers by a function."""

    answer: Callable[[int, int, Search], SubmapMatch | None] = lambda *_: None
    asked: list[tuple[int, int, Search]] = field(default_factory=list)

    def find(
        self, query: Submap, past: Submap, window: Search, scans: Sequence[Scan]
    ) -> Generator[None, None, SubmapMatch | None]:
        self.asked.append((query.anchor, past.anchor, window))
        yield
        return self.answer(query.anchor, past.anchor, window)

    def pairs(self) -> list[tuple[int, int]]:
        return [entry[:2] for entry in self.asked]


def mapped(path: Sequence[SE2], size: int, deviation: float) -> tuple[PoseGraph, list[Submap]]:
    """Return the graph of a path, and a submap of each few keyframes."""
    graph, submaps = PoseGraph(), []
    information = np.diag([deviation**-2, deviation**-2, 1e6])
    for k, pose in enumerate(path):
        graph.add_node(pose)
        if k:
            step = path[k - 1].inverse() @ pose
            graph.add_edge(Edge(k - 1, k, step, information, EdgeKind.MATCH))
    for first in range(0, len(path) - size + 1, size):
        submap = Submap(Field(0.05, 0.05))
        submap.nodes.extend(range(first, first + size))
        submap.poses.extend(path[first].inverse() @ path[k] for k in submap.nodes)
        steps = zip(submap.poses, submap.poses[1:], strict=False)
        submap.path_length = sum(a.distance(b) for a, b in steps)
        submaps.append(submap)
    return graph, submaps


def up_to(last: float) -> list[float]:
    """Return the distance driven up to each keyframe of a square, that of the last as given [m]."""
    return [*map(float, range(LAST)), last]


def square(deviation: float = 0.02) -> tuple[PoseGraph, list[Submap]]:
    """Return the graph of a square that ends beside its start, and submaps of five keyframes."""
    path = [SE2()]
    for k in range(LAST):
        path.append(path[-1] @ SE2(1.0, 0.0, math.pi / 2 if k % SIDE == SIDE - 1 else 0.0))
    graph, submaps = mapped(path, 5, deviation)
    return graph, submaps[:-1]


def out_and_back(deviation: float = 0.05, turns: int = 2) -> tuple[PoseGraph, list[Submap]]:
    """Return the graph of 3 m there and back, so often, in submaps of four keyframes."""
    one = [SE2(float(x), 0.3, 0.0) for x in range(4)]
    return mapped([*one, *one[::-1]] * turns, 4, deviation)
