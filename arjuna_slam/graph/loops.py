"""Loop closure: past submaps near a keyframe, the match against them and what is believed of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.graph.uncertainty import chained, plausible, relative_covariances, spread
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_CANDIDATES_MAX = 2  # submaps tried for a keyframe, to bound its time
_JUST_LEFT = 8.0  # travel within which matches join the keyframes anyway [m]
_BY_HAND = Window(0.75, 0.35, 3)  # a hand in RViz is no better


@dataclass(frozen=True)
class LoopConfig:
    """Parameters of loop closure; slam_toolbox's names."""

    do_loop_closing: bool = param(True, "Whether to close loops.")
    loop_search_maximum_distance: float = param(
        3.0, "Distance to a past keyframe within which its submap is tried.", unit="m", minimum=0.0
    )
    loop_search_space_dimension: float = param(
        30.0, "Width of the greatest search window.", unit="m", minimum=0.0, maximum=100.0
    )
    loop_search_angle: float = param(
        0.785,
        "Half the angle of the greatest search window.",
        unit="rad",
        minimum=0.01,
        maximum=3.15,
    )
    loop_match_minimum_response_coarse: float = param(
        0.35, "Mean likelihood that the search must reach.", minimum=0.0
    )
    loop_match_minimum_response_fine: float = param(
        0.45, "Share of points on the submap's surfaces after refinement.", minimum=0.0
    )
    loop_search_deviations: float = param(
        3.0, "How many deviations of what the graph does not know a search window reaches.",
        minimum=0.1, maximum=100.0,
    )  # fmt: skip
    loop_scan_window: float = param(
        1.0, "Half the window up to which a single scan is enough; beyond, submaps are compared.",
        unit="m", minimum=0.0, maximum=100.0,
    )  # fmt: skip
    loop_place_response: float = param(
        0.4, "Share of a submap's surfaces that must lie on a past one's.", minimum=0.0, maximum=1.0
    )
    loop_contradiction: float = param(
        0.08, "Share of a submap's points that a past one's beams may go through at most.",
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
        2.0, "Travel within which another match may support a correction.", unit="m", minimum=0.0
    )
    loop_agree_distance: float = param(
        0.1, "Position within which two matches agree.", unit="m", minimum=0.0
    )
    loop_agree_angle: float = param(
        0.03, "Heading within which two matches agree.", unit="rad", minimum=0.0
    )


class Submap(Protocol):
    """A run of keyframes to close a loop with, and their field in the first one's frame."""

    nodes: list[int]
    path_length: float
    bend: Floats

    @property
    def field(self) -> Field:
        """The reference that scans are matched against."""

    @property
    def anchor(self) -> int:
        """The node whose frame the field is in."""

    poses: list[SE2]

    def nearest(self, T_anchor_base: SE2) -> tuple[int, SE2]:
        """Return the keyframe nearest to a pose in the anchor's frame, and its pose."""


@dataclass(frozen=True)
class _Witness:
    travel: float
    correction: SE2
    edge: Edge


class LoopCloser:
    """Finds loop edges for new keyframes."""

    def __init__(self, config: LoopConfig, matcher: ScanMatcher) -> None:
        self._config = config
        self._matcher = matcher
        self._travel: list[float] = []
        self._tried: dict[int, float] = {}
        self._witnesses: list[_Witness] = []

    @property
    def travel(self) -> tuple[float, ...]:
        """Distance travelled when each keyframe was taken [m]."""
        return tuple(self._travel)

    def resume(self, travel: Floats, index: Ints | None = None) -> None:
        """Take over other keyframes, with the distance travelled up to each [m].

        Where they are what is left of those before, `index` is the new number of each of those, -1
        for those gone; None where they are another session's.
        """
        self._travel = travel.tolist()
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

        The keyframe is the newest node, taken after so much travel [m]; submaps are finished ones.
        """
        self._travel.append(travel)
        if not self._config.do_loop_closing:
            return []
        edges: list[Edge] = []
        for submap, window, past, covariance in self._candidates(graph, node, submaps):
            anchor = submap.anchor
            if travel - self._tried.get(anchor, -math.inf) < self._config.loop_retry_distance:
                continue
            prior = graph.pose(anchor).inverse() @ graph.pose(node)
            match = self._match(submap, surface, prior, window)
            expected = graph.pose(node).inverse() @ graph.pose(past)
            found = match.T_field_base.inverse() @ submap.poses[submap.nodes.index(past)]
            fits = plausible(expected, found, covariance)
            if match.status is not MatchStatus.MATCHED or not fits:
                self._tried[anchor] = travel
                continue
            edges.extend(self._believe(graph, submap, node, match, prior))
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
                best = match.response, _edge(submap, node, match)
        return None if best is None else best[1]

    def _candidates(
        self, graph: PoseGraph, node: int, submaps: Sequence[Submap]
    ) -> list[tuple[Submap, Window, int, Floats]]:
        """Return the nearest submaps with a keyframe within reach.

        Each has where to search, and its nearest keyframe with the covariance in the node's frame.
        """
        if not submaps:
            return []
        here = graph.poses[node, :2]
        distance = np.hypot(*(graph.poses[:node, :2] - here).T)
        config = self._config
        widest = config.loop_search_maximum_distance + config.loop_scan_window
        near = np.flatnonzero(distance < widest)
        first, last = np.array([(submap.nodes[0], submap.nodes[-1]) for submap in submaps]).T
        seen = np.searchsorted(near, last, "right") > np.searchsorted(near, first)
        candidates = []
        for k in np.flatnonzero(seen).tolist():
            past = submaps[k].nodes[int(distance[submaps[k].nodes].argmin())]
            if self._travel[node] - self._travel[past] > _JUST_LEFT and distance[past] < widest:
                candidates.append((k, past))
        if not candidates:
            return []
        covariances = relative_covariances(
            graph, node, np.array([p for _, p in candidates], np.intp)
        )
        found: list[tuple[float, int, Window, int]] = []
        for k, past in candidates:
            xy, theta = spread(covariances[past])
            wide = config.loop_search_deviations * xy
            within = config.loop_search_maximum_distance + wide
            if wide <= config.loop_scan_window and distance[past] < within:
                found.append((float(distance[past]), k, self._window(wide, theta), past))
        found.sort(key=lambda entry: entry[:2])
        return [(submaps[k], w, p, covariances[p]) for _, k, w, p in found[:_CANDIDATES_MAX]]

    def _window(self, wide: float, theta: float) -> Window:
        config = self._config
        half = min(0.3 + wide, 0.5 * config.loop_search_space_dimension)
        angle = min(0.1 + config.loop_search_deviations * theta, config.loop_search_angle)
        return Window(half, angle, 2 if half < 0.5 else 4)

    def _match(self, submap: Submap, surface: Surface, prior: SE2, window: Window) -> Match:
        config = self._config
        match = self._matcher.match(
            submap.field, surface, prior, window, config.loop_match_minimum_response_coarse
        )
        good = match.response >= config.loop_match_minimum_response_fine
        if match.status is MatchStatus.MATCHED and not good:
            return Match(MatchStatus.LOW_RESPONSE, prior, match.covariance, match.response)
        return match

    def _believe(
        self, graph: PoseGraph, submap: Submap, node: int, match: Match, prior: SE2
    ) -> list[Edge]:
        """Return the edges to add: at once if the correction is small, else once two agree."""
        edge = _edge(submap, node, match)
        change, c = prior.inverse() @ match.T_field_base, self._config
        near = math.hypot(change.x, change.y) < c.loop_sure_distance
        if near and abs(change.theta) < c.loop_sure_angle:
            return [edge]
        travel, reach = self._travel[node], c.loop_witness_distance
        self._witnesses = [w for w in self._witnesses if travel - w.travel < reach]
        correction = graph.pose(submap.anchor) @ match.T_field_base @ graph.pose(node).inverse()
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


def _edge(submap: Submap, node: int, match: Match) -> Edge:
    """Return the edge that a match makes, with the keyframe that saw most of what was matched."""
    past, T_anchor_past = submap.nearest(match.T_field_base)
    T_past_anchor = T_anchor_past.inverse()
    known = doubted(match.covariance_in(T_past_anchor))
    bent = chained(T_past_anchor, submap.bend, match.T_field_base, np.zeros((3, 3)))
    information = invert(known + bent)
    return Edge(past, node, T_past_anchor @ match.T_field_base, information, EdgeKind.LOOP)


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
