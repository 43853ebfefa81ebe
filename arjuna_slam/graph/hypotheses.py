"""Closures that are not believed yet, and the largest set of them that agrees.

Two closures agree where the loop through both comes back to where it began, within what the graph
and they know. Doors that are all alike make many closures, but only the true ones all agree. A
closure that walls over a large area constrain needs no other: no two such areas that look the same
lie near each other.

Source: Mangelson et al., Pairwise consistent measurement set maximization for robust multi-robot
map merging, 2018; the largest set is found greedily from each closure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, PoseGraph
from arjuna_slam.graph.uncertainty import chained, relative_covariances
from arjuna_slam.matching.scan_matcher import invert

_AHEAD = 1.0  # by how much a set must outweigh another of the same submaps
_NEAR = 1.5  # how near that is: corridors and areas that look the same lie further apart [m]
_SLACK = np.diag([0.05**2, 0.05**2, 0.005**2])  # what is left where all claim to know better


@dataclass(frozen=True)
class Closure:
    """A loop closure that may be true: an area that is perhaps seen again."""

    query: int  # number of the newer submap, or of a keyframe
    past: int  # number of the older submap; 0 for all, of a keyframe
    edge: Edge  # between a keyframe of the older and one of the newer
    weight: float  # what it counts for
    enough: float  # what the weights of a set with it must add up to
    # whether it fits nowhere else and walls over a large area constrain each direction
    wide: bool = False


class Hypotheses:
    """Closures held until enough of them agree.

    Those whose numbers differ by no more than `overlap` see the same and count once.
    """

    def __init__(self, overlap: int = 1) -> None:
        self._overlap = overlap
        self._held: list[Closure] = []
        self._weights: list[float] = []
        self._agree = np.zeros((0, 0), np.bool_)

    def add(self, graph: PoseGraph, closure: Closure) -> list[Closure]:
        """Add a closure and return those that are believed now, which are then no longer held."""
        agrees = np.array([*self._compare(graph, closure.edge), True])
        count = len(self._held)
        self._agree = np.pad(self._agree, ((0, 1), (0, 1)))
        self._agree[count, :] = self._agree[:, count] = agrees
        self._held.append(closure)
        self._weights = [_weight(graph, held) for held in self._held]
        chosen = self._supported(graph, self._largest(count))
        total = self._weight(chosen)
        steps = range(-self._overlap, self._overlap + 1)
        near = {self._held[k].query + step for k in chosen for step in steps}
        rivals = [k for k in np.flatnonzero(~agrees).tolist() if self._held[k].query in near]
        rival = max((self._against(chosen, self._largest(k)) for k in rivals), default=0.0)
        held_max = 60  # closures, the newest
        if count not in chosen or (rivals and total < rival + _AHEAD):
            self._drop({0} if len(self._held) > held_max else set())
            return []
        believed = [self._held[k] for k in chosen]
        self._drop({*chosen, *rivals})
        return believed

    def _against(self, chosen: list[int], rivals: list[int]) -> float:
        """Return the weight of a rival set: capped where only the other has a wide closure.

        Along rows of equal doors any number of closures agree, in the next corridor as well.
        """
        wide, rival_wide = (any(self._held[k].wide for k in ks) for ks in (chosen, rivals))
        total = self._weight(rivals)
        return min(total, _AHEAD) if wide and not rival_wide else total

    def _supported(self, graph: PoseGraph, chosen: list[int]) -> list[int]:
        """Return the closures of a set that have enough beside them to be believed.

        Along a corridor most closures know nothing: they agree with all that is said there, and
        support none of it. So a correction needs others that know its direction and move as far.
        """
        corrections = {k: _Correction.of(graph, self._held[k].edge) for k in chosen}
        kept = [k for k in chosen if self._is_supported(k, corrections)]
        total = self._weight(kept)
        return [k for k in kept if total >= self._held[k].enough]

    def _is_supported(self, k: int, corrections: dict[int, _Correction]) -> bool:
        """Return whether enough of a set supports a closure in each direction that it corrects.

        A correction as far as from one corridor to the next is not believed of doors alone.
        """
        own, enough = corrections[k], self._held[k].enough
        gap = own.moves(own.node)
        small = 0.3  # correction that needs no other closure that knows its direction [m]
        for axis in own.known:
            if abs(gap @ axis) <= small:
                continue
            alike = [o for o, other in corrections.items() if other.supports(own, axis)]
            beside = abs(gap @ axis) > _NEAR and not any(self._held[o].wide for o in alike)
            if beside or self._weight(alike) < enough:
                return False
        return True

    def _weight(self, chosen: list[int]) -> float:
        """Return what a set counts for: submaps that overlap see the same, and count once."""
        total = 0.0
        counted: list[Closure] = []
        for k in sorted(chosen, key=lambda k: (-self._weights[k], self._held[k].query)):
            closure = self._held[k]
            gaps = (
                max(abs(closure.query - other.query), abs(closure.past - other.past))
                for other in counted
            )
            if all(gap > self._overlap for gap in gaps):
                total += self._weights[k]
                counted.append(closure)
        return total

    def _largest(self, first: int) -> list[int]:
        chosen = [first]
        remaining = self._agree[first].copy()
        remaining[first] = False
        while remaining.any():
            support = np.where(remaining, self._agree[:, remaining].sum(axis=1), -1)
            best = int(support.argmax())
            chosen.append(best)
            remaining &= self._agree[best]
            remaining[best] = False
        return chosen

    def _drop(self, gone: set[int]) -> None:
        kept = [k for k in range(len(self._held)) if k not in gone]
        self._held = [self._held[k] for k in kept]
        self._agree = self._agree[np.ix_(kept, kept)]

    def _compare(self, graph: PoseGraph, edge: Edge) -> list[bool]:
        if not self._held:
            return []
        from_i, from_j = (relative_covariances(graph, node) for node in (edge.i, edge.j))
        return [self._agrees(graph, edge, closure.edge, from_i, from_j) for closure in self._held]

    @staticmethod
    def _agrees(graph: PoseGraph, edge: Edge, other: Edge, from_i: Floats, from_j: Floats) -> bool:
        """Go from `edge.i` to `other.j` over either closure and compare."""
        T_i_other = graph.pose(edge.i).inverse() @ graph.pose(other.i)
        T_j_other = graph.pose(edge.j).inverse() @ graph.pose(other.j)
        over_other = T_i_other @ other.T_i_j
        over_edge = edge.T_i_j @ T_j_other
        covariance = chained(T_i_other, from_i[other.i], other.T_i_j, invert(other.information))
        covariance += chained(edge.T_i_j, invert(edge.information), T_j_other, from_j[other.j])
        error = over_other.array() - over_edge.array()
        error[2] = math.remainder(error[2], 2.0 * math.pi)
        chi2_max = 11.3  # 99 % quantile of the chi-squared distribution of 3 degrees of freedom
        return bool(error @ np.linalg.solve(covariance + _SLACK, error) < chi2_max)


def _weight(graph: PoseGraph, closure: Closure) -> float:
    """Return what a closure counts for in the graph as others have bent it by now."""
    gap = float(np.hypot(*graph.residual(closure.edge)[:2]))
    wide = 2.0  # weight of a wide closure near to where the graph has it
    return wide if closure.wide and gap < _NEAR else closure.weight


@dataclass(frozen=True)
class _Correction:
    """The motion that an edge asks of its second node and the map there."""

    node: Floats  # the second node's position in map, `(2,) float64` [m]
    change: SE2  # motion of the map around the node
    known: Floats  # directions in map that the edge constrains, `(K, 2) float64`

    @staticmethod
    def of(graph: PoseGraph, edge: Edge) -> _Correction:
        variances, axes = np.linalg.eigh(invert(edge.information)[:2, :2])
        turn = SE2(0.0, 0.0, graph.pose(edge.i).theta)
        change = graph.pose(edge.i) @ edge.T_i_j @ graph.pose(edge.j).inverse()
        node = graph.poses[edge.j, :2].copy()
        directions = turn.apply(axes.T)
        asked = np.abs(directions @ (change.apply(node[None])[0] - node))
        firm = 0.5  # [m] deviation up to which a closure knows a direction
        beyond = 3.0  # deviations of a correction that claims to know its direction after all
        known = variances < np.maximum(firm, asked / beyond) ** 2
        return _Correction(node, change, directions[known])

    def moves(self, point: Floats) -> Floats:
        """Return how far it moves a point of map [m]."""
        gap: Floats = self.change.apply(point[None])[0] - point
        return gap

    def supports(self, other: _Correction, axis: Floats) -> bool:
        """Return whether it moves the other's node much as far along an axis as the other does."""
        same = 0.7  # cosine from which on two directions are one
        sees = (np.abs(self.known @ axis) > same).any()
        wanted = float(other.moves(other.node) @ axis)
        found = float(self.moves(other.node) @ axis)
        alike = 0.5  # share of a correction by which its support may differ
        return bool(sees and abs(found - wanted) < alike * abs(wanted))
