"""Loop closure: past submaps near a keyframe, the match against them and what is believed of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.graph.drift import Drift
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface

_CANDIDATES_MAX = 2  # submaps tried for a keyframe, to bound its time
_BY_HAND = Window(0.75, 0.35, 3)  # a hand in RViz is no better


@dataclass(frozen=True)
class LoopConfig:
    """Parameters of loop closure; slam_toolbox's names."""

    do_loop_closing: bool = param(True, "Whether to close loops.")
    loop_search_maximum_distance: float = param(
        3.0, "Distance to a past keyframe within which its submap is tried.", unit="m", minimum=0.0
    )
    loop_search_space_dimension: float = param(
        8.0, "Width of the greatest search window.", unit="m", minimum=0.1, maximum=100.0
    )
    loop_search_angle: float = param(
        0.35,
        "Half the angle of the greatest search window.",
        unit="rad",
        minimum=0.01,
        maximum=3.15,
    )
    loop_match_minimum_response_coarse: float = param(
        0.35, "Mean likelihood that the search must reach.", minimum=0.0, maximum=1.0
    )
    loop_match_minimum_response_fine: float = param(
        0.45, "Share of points on the submap's surfaces after refinement.", minimum=0.0, maximum=1.0
    )
    loop_drift_per_metre: float = param(
        0.03, "How much the search window grows with travel since the place was left.",
        minimum=0.0, maximum=1.0,
    )  # fmt: skip
    loop_retry_distance: float = param(
        0.5, "Travel within which a failed search is not repeated.", unit="m", minimum=0.0
    )
    loop_sure_distance: float = param(
        0.15, "Correction in position below which a match needs no witness.", unit="m", minimum=0.0
    )
    loop_sure_angle: float = param(
        0.05, "Correction in heading below which a match needs no witness.", unit="rad", minimum=0.0
    )
    loop_witness_distance: float = param(
        2.0, "Travel within which another match may bear a correction out.", unit="m", minimum=0.0
    )
    loop_agree_distance: float = param(
        0.1, "Position within which two matches agree.", unit="m", minimum=0.0
    )
    loop_agree_angle: float = param(
        0.03, "Heading within which two matches agree.", unit="rad", minimum=0.0
    )


class Submap(Protocol):
    """What a loop is closed with: a run of keyframes and their field in the first one's frame."""

    field: Field
    nodes: list[int]

    @property
    def anchor(self) -> int:
        """The node whose frame the field is in."""


@dataclass(frozen=True)
class _Witness:
    travel: float
    correction: SE2
    edge: Edge


class LoopCloser:
    """Finds loop edges for new keyframes.

    Args:
        config: The parameters.
        matcher: The scan matcher.
    """

    def __init__(self, config: LoopConfig, matcher: ScanMatcher) -> None:
        self._config = config
        self._matcher = matcher
        self._drift = Drift()
        self._tried: dict[int, float] = {}
        self._witnesses: list[_Witness] = []

    @property
    def travel(self) -> tuple[float, ...]:
        """Distance travelled when each keyframe was taken [m]."""
        return tuple(self._drift.travel)

    def resume(self, travel: NDArray[np.float64], index: NDArray[np.int64] | None = None) -> None:
        """Take over other keyframes.

        Args:
            travel: Distance travelled when each was taken, `(N,) float64` [m].
            index: Where they are what is left of those before, the new number of each of those,
                -1 for those gone; None where they are another session's.
        """
        self._drift.resume(travel)
        left = {} if index is None else {k: int(index[k]) for k in self._tried if index[k] >= 0}
        self._tried = {left[k]: tried for k, tried in self._tried.items() if k in left}
        self._witnesses.clear()

    def close(
        self,
        graph: PoseGraph,
        node: int,
        travel: float,
        surface: Surface,
        submaps: Sequence[Submap],
    ) -> list[Edge]:
        """Return the loop edges of a new keyframe, and those of earlier ones it confirms.

        Args:
            graph: The graph; it is not changed.
            node: The keyframe, the newest node.
            travel: Distance travelled when it was taken [m].
            surface: What it saw.
            submaps: The finished submaps.
        """
        self._drift.travel.append(travel)
        if not self._config.do_loop_closing:
            return []
        edges: list[Edge] = []
        for anchor, submap, nearest in self._candidates(graph, node, submaps):
            if travel - self._tried.get(anchor, -math.inf) < self._config.loop_retry_distance:
                continue
            prior = graph.pose(anchor).inverse() @ graph.pose(node)
            match = self._match(submap, surface, prior, self._error(node, nearest))
            if match.status is not MatchStatus.MATCHED:
                self._tried[anchor] = travel
                continue
            believed = self._believe(graph, anchor, node, match, prior)
            if believed:
                self._drift.close(node, nearest)
            edges.extend(believed)
        return edges

    def close_by_hand(
        self, graph: PoseGraph, node: int, pose: SE2, surface: Surface, submaps: Sequence[Submap]
    ) -> Edge | None:
        """Return the loop edge of a keyframe that a person has put somewhere, or None.

        Args:
            graph: The graph; it is not changed.
            node: The keyframe.
            pose: Where it was put, in map.
            surface: What it saw.
            submaps: The finished submaps; those with the keyframe in them are left out.
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
                information = match.information
                edge = Edge(submap.anchor, node, match.T_field_base, information, EdgeKind.LOOP)
                best = match.response, edge
        return None if best is None else best[1]

    def _candidates(
        self, graph: PoseGraph, node: int, submaps: Sequence[Submap]
    ) -> list[tuple[int, Submap, int]]:
        """Return the nearest submaps with a keyframe within reach, each with that keyframe."""
        if not submaps:
            return []
        here = graph.poses[node, :2]
        distance = np.hypot(*(graph.poses[:node, :2] - here).T)
        config = self._config
        reach = config.loop_search_maximum_distance
        widest = max(reach, 0.5 * config.loop_search_space_dimension)
        near = np.flatnonzero(distance < widest)
        first, last = np.array([(submap.nodes[0], submap.nodes[-1]) for submap in submaps]).T
        seen = np.searchsorted(near, last, "right") > np.searchsorted(near, first)
        found: list[tuple[float, int, int]] = []
        for k in np.flatnonzero(seen).tolist():
            d = distance[submaps[k].nodes]
            best = int(d.argmin())
            nearest = submaps[k].nodes[best]
            if d[best] < reach or d[best] < min(widest, self._error(node, nearest)):
                found.append((float(d[best]), k, nearest))
        found.sort()
        return [(submaps[k].anchor, submaps[k], n) for _, k, n in found[:_CANDIDATES_MAX]]

    def _error(self, node: int, past: int) -> float:
        """Return how far off a keyframe may be as seen from a past one [m]; in radians as well."""
        return self._config.loop_drift_per_metre * self._drift.between(node, past)

    def _match(self, submap: Submap, surface: Surface, prior: SE2, error: float) -> Match:
        config = self._config
        half = min(0.3 + error, 0.5 * config.loop_search_space_dimension)
        angle = min(0.1 + error, config.loop_search_angle)
        window = Window(half, angle, 2 if half < 0.5 else 4)
        match = self._matcher.match(
            submap.field, surface, prior, window, config.loop_match_minimum_response_coarse
        )
        good = match.response >= config.loop_match_minimum_response_fine
        if match.status is MatchStatus.MATCHED and not good:
            return Match(MatchStatus.LOW_RESPONSE, prior, match.covariance, match.response)
        return match

    def _believe(
        self, graph: PoseGraph, anchor: int, node: int, match: Match, prior: SE2
    ) -> list[Edge]:
        """Return the edges to add: at once if the correction is small, else once two agree."""
        edge = Edge(anchor, node, match.T_field_base, match.information, EdgeKind.LOOP)
        change, c = prior.inverse() @ match.T_field_base, self._config
        near = math.hypot(change.x, change.y) < c.loop_sure_distance
        if near and abs(change.theta) < c.loop_sure_angle:
            return [edge]
        travel, reach = self._drift.travel[node], c.loop_witness_distance
        self._witnesses = [w for w in self._witnesses if travel - w.travel < reach]
        correction = graph.pose(anchor) @ match.T_field_base @ graph.pose(node).inverse()
        here = graph.poses[node : node + 1, :2]
        for witness in self._witnesses:
            gap = witness.correction.apply(here) - correction.apply(here)
            turn = (witness.correction.inverse() @ correction).theta
            close = np.hypot(*gap[0]) < c.loop_agree_distance and abs(turn) < c.loop_agree_angle
            if close and witness.edge.j != node:
                self._witnesses.remove(witness)
                return [witness.edge, edge]
        self._witnesses.append(_Witness(travel, correction, edge))
        return []
