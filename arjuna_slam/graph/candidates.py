"""Candidates for a loop: past submaps that a keyframe or a submap may lie on, and how far off.

The graph bounds what it does not know of two nodes; so wide, and no wider, is a search. A narrow
one is done with a single scan, a wide one with all that a finished submap has seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.config import angle_param, length_param, param, share_param
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.graph.pose_graph import PoseGraph
from arjuna_slam.graph.rivals import APART
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.uncertainty import plausible, relative_covariances, spread
from arjuna_slam.matching.correlative import Window


@dataclass(frozen=True)
class LoopConfig:
    """Parameters of loop closure; slam_toolbox's names."""

    do_loop_closing: bool = param(True, "Whether to close loops.")
    loop_search_by_drift: bool = param(
        True,
        "Whether loops are searched as far as the graph may have drifted, by submaps too; else"
        " keyframes within loop_search_maximum_distance in the whole window.",
        theirs=False,
    )
    loop_search_maximum_distance: float = length_param(
        3.0, "Distance to a past keyframe within which its submap is tried."
    )
    loop_search_space_dimension: float = length_param(
        30.0, "Width of the greatest search window.", maximum=100.0
    )
    loop_search_angle: float = angle_param(
        0.785, "Half the angle of the greatest window.", minimum=0.01, maximum=3.15, theirs=0.349
    )
    loop_match_minimum_response_coarse: float = param(
        0.35, "Mean likelihood that the search must reach.", minimum=0.0
    )
    loop_match_minimum_response_fine: float = param(
        0.45, "Share of points on the submap's surfaces after refinement.", minimum=0.0
    )
    loop_search_deviations: float = param(
        3.0, "Deviations in the graph that a search window reaches.", minimum=0.1, maximum=100.0
    )
    loop_scan_window: float = length_param(
        1.0, "Half the window above which submaps are compared.", maximum=100.0
    )
    loop_place_response: float = share_param(
        0.4, "Share of a submap's surfaces that must lie on a past one's."
    )
    loop_contradiction: float = share_param(
        0.08, "Share of points that the other's beams may go through."
    )
    loop_submap_response: float = param(
        0.45, "Mean likelihood that the coarse search of a submap must reach.", minimum=0.0
    )
    loop_rival_share: float = share_param(0.87, "Share of the best likelihood that makes a rival.")
    loop_wall_crossed: float = length_param(
        1.2, "Longest wall that beams may cross: a door's width."
    )
    loop_wide_area: float = param(
        12.0, "Area of walls that holds a submap firmly.", unit="m^2", minimum=0.0
    )
    loop_retry_distance: float = length_param(
        0.5, "Travel within which a failed search is not repeated.", theirs=0.0
    )
    loop_sure_distance: float = length_param(
        0.15, "Correction in position below which a match needs no other.", theirs=1e6
    )
    loop_sure_angle: float = angle_param(
        0.05, "Correction in heading below which a match needs no other.", theirs=1e6
    )


@dataclass(frozen=True)
class Search:
    """Window of a past submap in which a keyframe or another submap is searched."""

    prior: SE2  # what is searched in the past one's frame, as the graph has it
    covariance: Floats  # of a node of the past one, seen from what is searched, by the graph
    xy: float  # half the window [m]
    theta: float  # half its angle [rad]
    T_past_node: SE2 = IDENTITY  # that node in the past one's frame
    expected: SE2 | None = None  # that node seen from what is searched; None for the anchor

    def is_plausible(self, T_past_query: SE2) -> bool:
        """Return whether the graph leaves a pose in the past submap open."""
        expected = self.prior.inverse() if self.expected is None else self.expected
        return plausible(expected, T_past_query.inverse() @ self.T_past_node, self.covariance)

    @property
    def ambiguous(self) -> bool:
        """True if the window has room for another pose that fits as well."""
        return self.xy >= 2.0 * APART

    def reaches_beside(self, best: SE2) -> bool:
        """Return whether another peak, apart from the best pose, may lie in the window."""
        off = max(abs(best.x - self.prior.x), abs(best.y - self.prior.y))
        return off + self.xy > APART

    def pieces(self, resolution: float) -> list[tuple[SE2, Window]]:
        """Return the window in pieces that take a bounded time, from the middle outwards."""
        depth = int(np.clip(np.log2(max(self.xy / resolution, 1.0)), 2, 5))
        volume, narrowest = 1.2, 0.03  # of a piece [m^2 rad]; its angle, however wide it is [rad]
        angle = min(self.theta, max(narrowest, volume / self.xy**2))
        count = int(np.ceil(self.theta / angle))
        middles = np.arange(1 - count, count, 2) * (self.theta / count)
        middles = middles[np.argsort(np.abs(middles), kind="stable")]
        x, y, theta = self.prior.x, self.prior.y, self.prior.theta
        window = Window(self.xy, self.theta / count, depth)
        return [(SE2(x, y, theta + middle), window) for middle in middles.tolist()]


def near_keyframe(
    config: LoopConfig,
    graph: PoseGraph,
    node: int,
    travel: Sequence[float],
    submaps: Sequence[Submap],
) -> list[tuple[Submap, Search]]:
    """Return the nearest submaps that the newest keyframe may lie on, known well enough for a scan.

    `travel` is the distance up to each keyframe [m].
    """
    most = 2  # submaps, to bound a keyframe's time
    just_left = 8.0  # [m] of travel within which matches join the keyframes anyway
    if not submaps:
        return []
    distance = np.hypot(*(graph.poses[:node, :2] - graph.poses[node, :2]).T)
    by_drift, widest = config.loop_search_by_drift, config.loop_search_maximum_distance
    if by_drift:
        widest += config.loop_scan_window
    near = np.flatnonzero(distance < widest)
    first, last = np.array([(submap.nodes[0], submap.nodes[-1]) for submap in submaps]).T
    seen = np.searchsorted(near, last, "right") > np.searchsorted(near, first)
    pasts = {}
    for k in np.flatnonzero(seen).tolist():
        past = submaps[k].nodes[int(distance[submaps[k].nodes].argmin())]
        if travel[node] - travel[past] > just_left and distance[past] < widest:
            pasts[k] = past
    if not pasts:
        return []
    covariances = relative_covariances(graph, node, np.array(list(pasts.values()), np.intp))
    found: list[tuple[float, int]] = []
    for k, past in pasts.items():
        off = config.loop_search_deviations * spread(covariances[past])[0] if by_drift else 0.0
        reached = distance[past] < config.loop_search_maximum_distance + off
        if off <= config.loop_scan_window and reached:
            found.append((float(distance[past]), k))
    chosen = [(submaps[k], pasts[k]) for _, k in sorted(found)[:most]]
    return [(s, _of_keyframe(config, graph, node, s, past, covariances)) for s, past in chosen]


def _of_keyframe(
    config: LoopConfig, graph: PoseGraph, node: int, submap: Submap, past: int, covariances: Floats
) -> Search:
    """Return where to search a keyframe in a submap of which it is near to one."""
    prior = graph.pose(submap.anchor).inverse() @ graph.pose(node)
    expected = graph.pose(node).inverse() @ graph.pose(past)
    T_past_node = submap.poses[submap.nodes.index(past)]
    window = _window(config, covariances[past], 0.3, 0.1)
    return Search(prior, covariances[past], *window, T_past_node, expected)


def of_submap(
    config: LoopConfig, graph: PoseGraph, query: Submap, past: Submap, covariance: Floats
) -> Search:
    """Return where to search a submap in a past one, by the covariance between their anchors."""
    prior = graph.pose(past.anchor).inverse() @ graph.pose(query.anchor)
    return Search(prior, covariance, *_window(config, covariance, 0.2, 0.03))


def _window(
    config: LoopConfig, covariance: Floats, more_xy: float, more_theta: float
) -> tuple[float, float]:
    """Return half the window [m] and half its angle [rad]: some deviations and a little more."""
    if not config.loop_search_by_drift:
        return 0.5 * config.loop_search_space_dimension, config.loop_search_angle
    xy, theta = spread(covariance)
    half = min(
        more_xy + config.loop_search_deviations * xy, 0.5 * config.loop_search_space_dimension
    )
    return half, min(more_theta + config.loop_search_deviations * theta, config.loop_search_angle)


def near_submap(
    config: LoopConfig, graph: PoseGraph, k: int, submaps: Sequence[Submap]
) -> list[tuple[float, int, Search]]:
    """Return the past submaps that one may lie on, the nearest first, each with its gap [m].

    Left out are those that a loop edge joins to it, if their poses are known well.
    """
    query, known_below = submaps[k], 0.3  # [m] deviation
    covariances = relative_covariances(graph, query.anchor)
    gaps, joined = _gaps(graph, query.nodes), _joined(graph, query.nodes)
    found: list[tuple[float, int, Search]] = []
    for past in _within_reach(config, gaps, submaps[: max(k - 1, 0)]):
        if submaps[past].nodes[-1] >= query.nodes[0]:  # they share keyframes
            continue
        covariance = covariances[submaps[past].anchor]
        if spread(covariance)[0] < known_below and joined[submaps[past].nodes].any():
            continue
        gap = float(gaps[submaps[past].nodes].min())
        search = of_submap(config, graph, query, submaps[past], covariance)
        if gap < config.loop_search_maximum_distance + search.xy:
            found.append((gap, past, search))
    return sorted(found, key=lambda entry: entry[:2])


def _within_reach(config: LoopConfig, gaps: Floats, submaps: Sequence[Submap]) -> Ints:
    """Return which submaps the widest window may reach, by their anchors alone."""
    widest = config.loop_search_maximum_distance + 0.5 * config.loop_search_space_dimension
    anchors = np.array([submap.anchor for submap in submaps], np.intp)
    lengths = np.array([submap.path_length for submap in submaps])
    longer = 1.5  # as a path may be longer in the graph
    return np.flatnonzero(gaps[anchors] < widest + longer * lengths)


def _joined(graph: PoseGraph, nodes: list[int]) -> Bools:
    """Return which nodes a loop edge joins to some, `(N,) bool`."""
    table = graph.table
    own, joined = np.zeros((2, len(graph)), np.bool_)
    own[nodes] = True
    joined[table.i[table.loop & own[table.j]]] = True
    joined[table.j[table.loop & own[table.i]]] = True
    return joined


def _gaps(graph: PoseGraph, nodes: list[int]) -> Floats:
    """Return how far each node is from the nearest of some, `(N,) float64` [m]."""
    own = graph.poses[nodes[:: max(1, len(nodes) // 6)], :2]
    gaps = np.hypot(*(graph.poses[:, None, :2] - own[None]).transpose(2, 0, 1))
    return np.asarray(gaps.min(axis=1), np.float64)
