"""Keyframes: the pose graph with the scan at each of its nodes, and the map they make."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.config import length_param, param, share_param
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, PoseGraph
from arjuna_slam.mapping.occupancy import Occupancy
from arjuna_slam.mapping.session import Session

PosedScan = tuple[Scan, SE2]
"""A scan and the robot's pose in map at it."""
_MOVED_POSITION_CELLS = 0.5  # from which on a scan is drawn again: less leaves the same cells


class Keyframes:
    """The keyframes of a mapping session; a scan is traced when it is new or has moved.

    Args:
        resolution: Edge of a cell of the map [m].
        range_max: Longest range traced [m].
        min_pass_through: Beams that must come to a cell for it to be known, and one more.
        occupancy_threshold: Share of them that must end there for it to be occupied.
        clear_without_return: Whether beams without return clear up to the longest range.
        thin_walls: Whether cells that fewer beams end in than beside are no part of a wall.

    Attributes:
        graph: Their poses and the measurements between them.
        travel: The distance driven up to each [m].
    """

    def __init__(
        self,
        resolution: float,
        range_max: float,
        min_pass_through: int = 2,
        occupancy_threshold: float = 0.1,
        clear_without_return: bool = True,
        thin_walls: bool = True,
    ) -> None:
        self._resolution = resolution
        self._range_max, self._clear_all = range_max, clear_without_return
        self._occupancy = Occupancy(resolution, min_pass_through, occupancy_threshold, thin_walls)
        self._scans: list[Scan] = []
        self._traced = np.empty((0, 3))
        self.graph = PoseGraph()
        self.travel: list[float] = []

    @property
    def scans(self) -> tuple[Scan, ...]:
        """The scan at each node."""
        return tuple(self._scans)

    def add(self, scan: Scan, T_map_base: SE2, travel: float = 0.0) -> int:
        """Add a scan at its pose in map, after so much travel [m], and return its node."""
        self._scans.append(scan)
        self.travel.append(travel)
        return self.graph.add_node(T_map_base)

    def adopt(self, session: Session) -> None:
        """Take over a session's keyframes and edges."""
        each = zip(session.scans, session.poses, session.travel.tolist(), strict=True)
        for scan, pose, travel in each:
            self.add(scan, SE2.from_array(pose), travel)
        for edge in session.edges:
            self.graph.add_edge(edge)

    def nearest(self, T_map_base: SE2) -> int:
        """Return the node nearest to a pose in map."""
        position = T_map_base.x, T_map_base.y
        return int(np.hypot(*(self.graph.poses[:, :2] - position).T).argmin())

    def map(
        self, most_moved: int | None = None, passing: Iterable[PosedScan] = ()
    ) -> OccupancyGrid | None:
        """Return the map (-1, 0 and 100), or None without scans; trace what is new or moved.

        Of the scans that have moved at most `most_moved` are traced again, those that moved
        farthest first; None for all. Scans that are `passing` are in this map alone.
        """
        if not self._scans:
            return None
        poses = self.graph.poses
        for k in self._moved()[:most_moved].tolist():
            self._trace(self._scans[k], self._traced[k], -1)
            self._trace(self._scans[k], poses[k], 1)
            self._traced[k] = poses[k]
        for k in range(len(self._traced), len(poses)):
            self._trace(self._scans[k], poses[k], 1)
        self._traced = np.concatenate((self._traced, poses[len(self._traced) :]))
        passing = list(passing)
        for scan, pose in passing:
            self._trace(scan, pose.array(), 1)
        grid = self._occupancy.grid(self._scans[-1].stamp)
        for scan, pose in passing:
            self._trace(scan, pose.array(), -1)
        return grid

    def _trace(self, scan: Scan, pose: Floats, sign: int) -> None:
        if not self._clear_all:  # as Karto's OccupancyGrid::AddScan
            scan = replace(scan, ranges=np.where(scan.ranges < scan.range_max, scan.ranges, np.nan))
        self._occupancy.trace(scan, pose, self._range_max, sign)

    @property
    def map_behind(self) -> bool:
        """True if scans are new or have moved since the map was last returned."""
        return len(self._scans) > len(self._traced) or len(self._moved()) > 0

    def _moved(self) -> Ints:
        """Return the traced scans that have moved enough to be traced again, the farthest first."""
        change = self.graph.poses[: len(self._traced)] - self._traced
        gap = np.hypot(change[:, 0], change[:, 1]) / (_MOVED_POSITION_CELLS * self._resolution)
        moved_heading = 0.005  # the same [rad]: half a cell at 5 m
        turn = np.abs(np.remainder(change[:, 2] + np.pi, 2.0 * np.pi) - np.pi) / moved_heading
        far = np.maximum(gap, turn)
        order = np.argsort(-far, kind="stable")
        return order[: int((far > 1.0).sum())]


_BRIDGE = np.diag([1.0 / 0.02**2, 1.0 / 0.02**2, 1.0 / 0.01**2])  # information across a gap


@dataclass(frozen=True)
class LifelongConfig:
    """Parameters of forgetting."""

    lifelong: bool = param(
        False, "Whether keyframes that newer ones cover are forgotten, so that memory is bounded."
    )
    lifelong_cover_distance: float = length_param(
        0.5, "How near a newer keyframe sees what an older one saw."
    )
    lifelong_cover_share: float = share_param(
        0.9, "Share of a submap's keyframes that newer ones must cover."
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
