"""Forgetting: submaps that newer ones cover, and a graph without their keyframes.

Source: the idea of Kretzschmar and Stachniss, Information-theoretic compression of pose graphs,
2012: what the map has seen again may be removed, and its measurements are replaced by what the
graph has made of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.mapping.session import Session

_BRIDGE = np.diag([1.0 / 0.02**2, 1.0 / 0.02**2, 1.0 / 0.01**2])  # information across a gap


@dataclass(frozen=True)
class LifelongConfig:
    """Parameters of forgetting."""

    lifelong: bool = param(
        False, "Whether keyframes that newer ones cover are forgotten, so that memory is bounded."
    )
    lifelong_cover_distance: float = param(
        0.5, "How near a newer keyframe sees what an older one saw.", unit="m", minimum=0.0
    )
    lifelong_cover_share: float = param(
        0.9, "Share of a submap's keyframes that newer ones must cover.", minimum=0.0, maximum=1.0
    )


def forget_submap(
    config: LifelongConfig, session: Session, submap: int
) -> tuple[Session, Ints] | None:
    """Return `prune` of a session without a submap, or None where the submap is still needed."""
    if not is_redundant(config, session.poses, session.submaps[submap]):
        return None
    keep = np.zeros(len(session.poses), np.bool_)
    for k, nodes in enumerate(session.submaps):
        keep[list(nodes)] |= k != submap
    keep[session.submaps[submap][0]] = False  # the anchor goes, and with it the submap
    return prune(session, keep)


def is_redundant(config: LifelongConfig, poses: Floats, nodes: Sequence[int]) -> bool:
    """Return whether newer keyframes cover a submap's `nodes`; poses `(N, 3)` of all keyframes."""
    newer = poses[max(nodes) + 1 :, :2]
    if len(newer) == 0:
        return False
    gaps = np.linalg.norm(poses[list(nodes), None, :2] - newer[None], axis=2).min(axis=1)
    covered = gaps < config.lifelong_cover_distance
    return bool(covered.mean() >= config.lifelong_cover_share)


def prune(session: Session, keep: Bools) -> tuple[Session, Ints]:
    """Return a session of the keyframes that are kept, `(N,) bool`, at least one.

    And the new number of each keyframe, `(N,) int64`, -1 for those gone.
    """
    kept = np.flatnonzero(keep)
    index = np.where(keep, np.cumsum(keep) - 1, -1)
    edges = [moved for edge in session.edges if (moved := _move(session, edge, kept, index))]
    edges += _bridges(session, kept)
    submaps = tuple(
        tuple(int(index[node]) for node in nodes if keep[node])
        for nodes in session.submaps
        if keep[nodes[0]]
    )
    scans = tuple(session.scans[k] for k in kept)
    pruned = Session(scans, session.poses[kept], session.travel[kept], tuple(edges), submaps)
    return pruned, index


def _move(session: Session, edge: Edge, kept: Ints, index: Ints) -> Edge | None:
    """Return an edge between kept keyframes; a loop's end that goes is moved to the next one."""
    i, j = int(index[edge.i]), int(index[edge.j])
    if i >= 0 and j >= 0:
        return Edge(i, j, edge.T_i_j, edge.information, edge.kind)
    if edge.kind is not EdgeKind.LOOP:
        return None
    a, b = _next(kept, edge.i), _next(kept, edge.j)
    if a == b:
        return None
    T_a_i = SE2.from_array(session.poses[a]).inverse() @ SE2.from_array(session.poses[edge.i])
    T_j_b = SE2.from_array(session.poses[edge.j]).inverse() @ SE2.from_array(session.poses[b])
    measured = T_a_i @ edge.T_i_j @ T_j_b
    doubt = 0.5  # factor on the information of a measurement moved to another keyframe
    return Edge(int(index[a]), int(index[b]), measured, doubt * edge.information, edge.kind)


def _next(kept: Ints, node: int) -> int:
    return int(kept[np.abs(kept - node).argmin()])


def _bridges(session: Session, kept: Ints) -> list[Edge]:
    edges = []
    for new, (a, b) in enumerate(pairwise(kept.tolist())):
        if b != a + 1:
            T = SE2.from_array(session.poses[a]).inverse() @ SE2.from_array(session.poses[b])
            edges.append(Edge(new, new + 1, T, _BRIDGE, EdgeKind.MATCH))
    return edges
