"""Closures that are not believed yet, and the largest set of them that agrees.

Two closures agree where the loop through both comes back to where it began, within what the graph
and they know. Doors that are all alike make many closures, but only the true ones all agree.

Source: Mangelson et al., Pairwise consistent measurement set maximization for robust multi-robot
map merging, 2018; the largest set is found greedily from each closure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, PoseGraph
from arjuna_slam.graph.uncertainty import relative_covariances
from arjuna_slam.matching.scan_matcher import invert

_AGREE = 11.3  # squared deviations in three degrees of freedom: 99 % of true pairs
_AHEAD = 1.0  # by how much a set must outweigh another of the same submaps
_HELD_MAX = 60  # the newest are kept
_SLACK = np.diag([0.05**2, 0.05**2, 0.005**2])  # what is left where all claim to know better


@dataclass(frozen=True)
class Closure:
    """A place seen again, perhaps.

    Attributes:
        query: Number of the newer submap.
        past: Number of the older.
        edge: Between a keyframe of the older and one of the newer.
        weight: What it counts for.
    """

    query: int
    past: int
    edge: Edge
    weight: float


class Hypotheses:
    """Closures held until enough of them agree."""

    def __init__(self) -> None:
        self._held: list[Closure] = []
        self._agree = np.zeros((0, 0), np.bool_)

    def add(self, graph: PoseGraph, closure: Closure, enough: float) -> list[Closure]:
        """Add a closure and return those that are believed now, which are then no longer held.

        Args:
            graph: The graph.
            closure: The closure.
            enough: What the weights of a set must add up to.
        """
        agrees = np.array([*self._compare(graph, closure.edge), True])
        count = len(self._held)
        self._agree = np.pad(self._agree, ((0, 1), (0, 1)))
        self._agree[count, :] = self._agree[:, count] = agrees
        self._held.append(closure)
        chosen = self._largest(count)
        total = self._weight(chosen)
        near = {self._held[k].query + step for k in chosen for step in (-1, 0, 1)}
        rivals = [k for k in np.flatnonzero(~agrees).tolist() if self._held[k].query in near]
        rival = max((self._weight(self._largest(k)) for k in rivals), default=0.0)
        if total < enough or (rivals and total < rival + _AHEAD):
            self._drop({0} if len(self._held) > _HELD_MAX else set())
            return []
        believed = [self._held[k] for k in chosen]
        self._drop({*chosen, *rivals})
        return believed

    def _weight(self, chosen: list[int]) -> float:
        """Return what a set counts for: submaps that overlap see the same, and count once."""
        total = 0.0
        counted: list[Closure] = []
        for closure in sorted((self._held[k] for k in chosen), key=lambda c: (-c.weight, c.query)):
            seen = (
                abs(closure.query - other.query) < 2 and abs(closure.past - other.past) < 2
                for other in counted
            )
            if not any(seen):
                total += closure.weight
                counted.append(closure)
        return total

    def _largest(self, first: int) -> list[int]:
        """Return a large set with a closure in it that agrees in pairs."""
        chosen = [first]
        left = self._agree[first].copy()
        left[first] = False
        while left.any():
            support = np.where(left, self._agree[:, left].sum(axis=1), -1)
            best = int(support.argmax())
            chosen.append(best)
            left &= self._agree[best]
            left[best] = False
        return chosen

    def _drop(self, gone: set[int]) -> None:
        kept = [k for k in range(len(self._held)) if k not in gone]
        self._held = [self._held[k] for k in kept]
        self._agree = self._agree[np.ix_(kept, kept)]

    def _compare(self, graph: PoseGraph, edge: Edge) -> list[bool]:
        """Tell which of the closures held agree with one."""
        if not self._held:
            return []
        from_i, from_j = (relative_covariances(graph, node) for node in (edge.i, edge.j))
        return [self._agrees(graph, edge, closure.edge, from_i, from_j) for closure in self._held]

    @staticmethod
    def _agrees(
        graph: PoseGraph,
        edge: Edge,
        other: Edge,
        from_i: NDArray[np.float64],
        from_j: NDArray[np.float64],
    ) -> bool:
        """Go from `edge.i` to `other.j` over either closure and compare."""
        T_i_other = graph.pose(edge.i).inverse() @ graph.pose(other.i)
        T_j_other = graph.pose(edge.j).inverse() @ graph.pose(other.j)
        over_other = T_i_other @ other.T_i_j
        over_edge = edge.T_i_j @ T_j_other
        covariance = chained(T_i_other, from_i[other.i], other.T_i_j, invert(other.information))
        covariance += chained(edge.T_i_j, invert(edge.information), T_j_other, from_j[other.j])
        error = over_other.array() - over_edge.array()
        error[2] = math.remainder(error[2], 2.0 * math.pi)
        return bool(error @ np.linalg.solve(covariance + _SLACK, error) < _AGREE)


def chained(
    T_a_b: SE2, first: NDArray[np.float64], T_b_c: SE2, second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance of `T_a_b @ T_b_c`, translation in the axes of a, `(3, 3) float64`.

    Args:
        T_a_b: The first transform.
        first: Its covariance, translation in the axes of a.
        T_b_c: The second.
        second: Its covariance, translation in the axes of b.
    """
    turn = SE2(0.0, 0.0, T_a_b.theta).matrix()
    way = turn @ np.array([T_b_c.x, T_b_c.y, 0.0])
    lever = np.eye(3)
    lever[0, 2], lever[1, 2] = -way[1], way[0]
    result: NDArray[np.float64] = lever @ first @ lever.T + turn @ second @ turn.T
    return result
