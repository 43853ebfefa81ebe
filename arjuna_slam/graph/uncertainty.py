"""Bounds on the relative error of two nodes of a pose graph, which limit the search for a loop.

The covariance along the surest chain of edges between two nodes bounds their relative covariance in
the graph from above, at the cost of one shortest-path search for all nodes.

Source: Bosse et al., Simultaneous localization and map building in large-scale cyclic environments
using the Atlas framework, 2004, section 3.3 (Dijkstra's projection).
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.graph.pose_graph import PoseGraph

_LEVER = 5.0  # error in position that an error in heading of 1 rad counts for [m]
_SLACK = np.diag([0.1**2, 0.1**2, 0.02**2])  # on top of what the graph does not know
_UNKNOWN = 1e6  # variance of what no chain reaches


def relative_covariances(
    graph: PoseGraph, node: int, wanted: NDArray[np.intp] | None = None
) -> Floats:
    """Return a bound on the covariance of nodes' poses in the frame of one, `(N, 3, 3)`.

    Those of nodes that are not `wanted` may stay unknown, which spares the search among them;
    None wants all.
    """
    table = graph.table
    open_ = np.full(len(graph.poses), wanted is None)
    if wanted is not None:
        open_[wanted] = True
    along, travel = _propagate(graph.poses, table.i, table.j, table.covariance, node, open_)
    near_share = 0.25  # of a short chain's covariance: its edges claim less than they know
    far_share = 2.0  # of a long one's: what neighbours err by alike adds up faster than at random
    memory = 50.0  # travel over which matches err alike, by `bench loops --log` [m]
    share = near_share + (far_share - near_share) * np.minimum(travel / memory, 1.0)
    bound: Floats = share[:, None, None] * along
    return bound


def spread(covariance: Floats) -> tuple[float, float]:
    """Return the greatest deviation in position [m] and that in heading [rad]."""
    half = 0.5 * (covariance[0, 0] - covariance[1, 1])
    mean = 0.5 * (covariance[0, 0] + covariance[1, 1])
    return float(np.sqrt(mean + np.hypot(half, covariance[0, 1]))), float(np.sqrt(covariance[2, 2]))


def chained(T_a_b: SE2, first: Floats, T_b_c: SE2, second: Floats) -> Floats:
    """Return the covariance of `T_a_b @ T_b_c`, translation in the axes of a, `(3, 3) float64`.

    `first` is that of `T_a_b` in the axes of a, `second` that of `T_b_c` in the axes of b.
    """
    turn = SE2(0.0, 0.0, T_a_b.theta).matrix()
    offset = turn @ np.array([T_b_c.x, T_b_c.y, 0.0])
    lever = np.eye(3)
    lever[0, 2], lever[1, 2] = -offset[1], offset[0]
    result: Floats = lever @ first @ lever.T + turn @ second @ turn.T
    return result


def plausible(expected: SE2, found: SE2, covariance: Floats) -> bool:
    """Return whether a node's pose in another's frame, as matched, fits the one that the graph has.

    `covariance` is the bound of `relative_covariances`, `(3, 3) float64`.
    """
    error = found.array() - expected.array()
    error[2] = wrap(float(error[2]))
    chi2_max = 16.0  # four deviations
    return bool(error @ np.linalg.solve(covariance + _SLACK, error) < chi2_max)


@njit(cache=True)
def _propagate(
    poses: Floats, i: Ints, j: Ints, covariance: Floats, node: int, open_: Bools
) -> tuple[Floats, Floats]:
    """Return the covariance along the surest chain to each node, and its length [m]."""
    starts, links = _links(len(poses), i, j)
    unreached, before = open_.sum(), np.full(len(poses), -1)
    result = np.zeros((len(poses), 3, 3))
    for k in range(len(poses)):
        result[k, 0, 0] = result[k, 1, 1] = result[k, 2, 2] = _UNKNOWN
    result[node] = 0.0
    travel = np.zeros(len(poses))
    done = np.zeros(len(poses), np.bool_)
    best = np.full(len(poses), np.inf)
    best[node] = 0.0
    heap = [(0.0, node)]
    c, s = np.cos(poses[node, 2]), np.sin(poses[node, 2])
    while heap:
        _, here = heapq.heappop(heap)
        if done[here]:
            continue
        done[here] = True
        e = before[here]
        if e >= 0:
            last = j[e] if i[e] == here else i[e]
            _chain(poses, last, here, i[e], covariance[e], c, s, result)
            gap = poses[here, :2] - poses[last, :2]
            travel[here] = travel[last] + math.hypot(gap[0], gap[1])
        unreached -= open_[here]
        if unreached == 0:
            break
        for link in range(starts[here], starts[here + 1]):
            e = links[link]
            there = j[e] if i[e] == here else i[e]
            if done[there]:
                continue
            length = best[here] + _length(covariance[e])
            if length < best[there]:
                best[there], before[there] = length, e
                heapq.heappush(heap, (length, there))
    return result, travel


@njit(cache=True)
def _length(edge: Floats) -> float:
    """Return how much an edge of a covariance `(3, 3)` adds to what is not known."""
    length: float = edge[0, 0] + edge[1, 1] + _LEVER**2 * edge[2, 2]
    return length


@njit(cache=True)
def _links(count: int, i: Ints, j: Ints) -> tuple[Ints, Ints]:
    starts = np.zeros(count + 1, np.int64)
    for e in range(len(i)):
        starts[i[e] + 1] += 1
        starts[j[e] + 1] += 1
    starts = np.cumsum(starts)
    fill = starts[:-1].copy()
    links = np.empty(2 * len(i), np.int64)
    for e in range(len(i)):
        links[fill[i[e]]] = e
        fill[i[e]] += 1
        links[fill[j[e]]] = e
        fill[j[e]] += 1
    return starts, links


@njit(cache=True)
def _chain(
    poses: Floats,
    here: int,
    there: int,
    first: int,
    edge: Floats,
    c: float,
    s: float,
    result: Floats,
) -> None:
    """Set the covariance of a node from that of the one before it and of the edge between.

    An error of the heading before moves the node sideways to the edge; the edge's own error lies
    in the axes of its first node, whose heading it moves where that is the new one.
    """
    wx, wy = poses[there, 0] - poses[here, 0], poses[there, 1] - poses[here, 1]
    dx, dy = c * wx + s * wy, c * wy - s * wx
    lever = np.eye(3)
    lever[0, 2], lever[1, 2] = -dy, dx
    turn = np.zeros((3, 3))
    angle = poses[first, 2]
    ec, es = np.cos(angle) * c + np.sin(angle) * s, np.sin(angle) * c - np.cos(angle) * s
    turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1], turn[2, 2] = ec, -es, es, ec, 1.0
    if first == there:
        turn[0, 2], turn[1, 2] = -dy, dx
    result[there] = lever @ result[here] @ lever.T + turn @ edge @ turn.T
