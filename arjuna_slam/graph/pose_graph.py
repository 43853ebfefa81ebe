"""The pose graph: keyframe poses and the measurements between them."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.se2 import SE2
from arjuna_slam.matching.scan_matcher import invert

_VAGUE = 1e-9 * np.eye(3)  # what an edge that says nothing of a direction knows of it


class EdgeKind(enum.Enum):
    """Origin of a measurement."""

    ODOMETRY = "odometry"
    MATCH = "match"
    LOOP = "loop"


@dataclass(frozen=True)
class Edge:
    """A measured pose of node `j` in the frame of node `i`."""

    i: int  # index of the first node
    j: int  # index of the second node
    T_i_j: SE2  # the measurement
    information: Floats  # of `x, y, theta` in the frame of `i`, `(3, 3) float64`
    kind: EdgeKind  # where it comes from
    # information on the same pose from edges beside it, which bounds how far the chain over
    # it may be off, `(3, 3) float64`; None for none
    prior: Floats | None = None


class EdgeTable:
    """The measurements as columns, for the optimiser."""

    def __init__(self) -> None:
        self._count = 0
        self._nodes = np.empty((64, 2), np.int64)
        self._measured = np.empty((64, 3))
        self._information = np.empty((64, 3, 3))
        self._covariance = np.empty((64, 3, 3))
        self._loop = np.empty(64, np.bool_)

    def __len__(self) -> int:
        """Return the number of edges."""
        return self._count

    @staticmethod
    def of(edges: Iterable[Edge]) -> EdgeTable:
        """Return the table of some edges."""
        table = EdgeTable()
        for edge in edges:
            table.append(edge)
        return table

    def append(self, edge: Edge) -> None:
        """Add an edge."""
        if self._count == len(self._nodes):
            self._nodes = np.concatenate((self._nodes, np.empty_like(self._nodes)))
            self._measured = np.concatenate((self._measured, np.empty_like(self._measured)))
            self._information = np.concatenate(
                (self._information, np.empty_like(self._information))
            )
            self._covariance = np.concatenate((self._covariance, np.empty_like(self._covariance)))
            self._loop = np.concatenate((self._loop, np.empty_like(self._loop)))
        k = self._count
        self._nodes[k] = edge.i, edge.j
        self._measured[k] = edge.T_i_j.x, edge.T_i_j.y, edge.T_i_j.theta
        self._information[k] = edge.information
        beside = _VAGUE if edge.prior is None else edge.prior
        self._covariance[k] = invert(edge.information + beside)
        self._loop[k] = edge.kind is EdgeKind.LOOP
        self._count += 1

    @property
    def i(self) -> Ints:
        """First node of each edge, `(E,) int64`."""
        return self._nodes[: self._count, 0]

    @property
    def j(self) -> Ints:
        """Second node of each edge, `(E,) int64`."""
        return self._nodes[: self._count, 1]

    @property
    def measured(self) -> Floats:
        """Measured x, y, theta, `(E, 3) float64` [m, m, rad]."""
        return self._measured[: self._count]

    @property
    def information(self) -> Floats:
        """Information of each edge, `(E, 3, 3) float64`."""
        return self._information[: self._count]

    @property
    def covariance(self) -> Floats:
        """Covariance of each edge, `(E, 3, 3) float64`."""
        return self._covariance[: self._count]

    @property
    def loop(self) -> Bools:
        """Which edges close loops, `(E,) bool`."""
        return self._loop[: self._count]


class PoseGraph:
    """Nodes and the measurements between them."""

    def __init__(self) -> None:
        self._poses = np.empty((64, 3))
        self._count = 0
        self.edges: list[Edge] = []
        self.table = EdgeTable()

    def __len__(self) -> int:
        """Return the number of nodes."""
        return self._count

    @property
    def poses(self) -> Floats:
        """A view of all poses `x, y, theta` in map, `(N, 3) float64` [m, m, rad]."""
        return self._poses[: self._count]

    @poses.setter
    def poses(self, values: Floats) -> None:
        self._poses[: self._count] = values

    def pose(self, node: int) -> SE2:
        """Return a node's pose in map."""
        return SE2.from_array(self._poses[node])

    def add_node(self, pose: SE2) -> int:
        """Add a node and return its index."""
        if self._count == len(self._poses):
            self._poses = np.concatenate((self._poses, np.empty_like(self._poses)))
        self._poses[self._count] = pose.array()
        self._count += 1
        return self._count - 1

    def add_edge(self, edge: Edge) -> None:
        """Add a measurement.

        Raises:
            ValueError: A node does not exist or both are the same.
        """
        if not (0 <= edge.i < self._count and 0 <= edge.j < self._count) or edge.i == edge.j:
            raise ValueError(
                f"edge {edge.i} -> {edge.j}: two different nodes of 0..{self._count - 1} are valid"
            )
        self.edges.append(edge)
        self.table.append(edge)

    def remove_edges(self, unwanted: Bools) -> None:
        """Take some measurements back, `(E,) bool`."""
        self.edges = [
            edge for edge, gone in zip(self.edges, unwanted.tolist(), strict=True) if not gone
        ]
        self.table = EdgeTable.of(self.edges)

    def residual(self, edge: Edge) -> Floats:
        """Return `x, y, theta` of the pose of `j` in `i` less the measurement, `(3,) float64`."""
        actual = self.pose(edge.i).inverse() @ self.pose(edge.j)
        error = actual.array() - edge.T_i_j.array()
        error[2] = np.remainder(error[2] + np.pi, 2.0 * np.pi) - np.pi
        return error
