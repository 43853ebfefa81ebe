"""The pose graph: keyframe poses and the measurements between them."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2


class EdgeKind(enum.Enum):
    """Where a measurement comes from."""

    ODOMETRY = "odometry"
    MATCH = "match"
    LOOP = "loop"


@dataclass(frozen=True)
class Edge:
    """A measured pose of node `j` in the frame of node `i`.

    Attributes:
        i: Index of the first node.
        j: Index of the second node.
        T_i_j: The measurement.
        information: Of `x, y, theta` in the frame of `i`, `(3, 3) float64`.
        kind: Where it comes from.
    """

    i: int
    j: int
    T_i_j: SE2
    information: NDArray[np.float64]
    kind: EdgeKind


class PoseGraph:
    """Nodes and edges, both only ever added."""

    def __init__(self) -> None:
        self._poses = np.empty((64, 3))
        self._count = 0
        self.edges: list[Edge] = []

    def __len__(self) -> int:
        """Return the number of nodes."""
        return self._count

    @property
    def poses(self) -> NDArray[np.float64]:
        """A view of all poses `x, y, theta` in map, `(N, 3) float64` [m, m, rad]."""
        return self._poses[: self._count]

    @poses.setter
    def poses(self, values: NDArray[np.float64]) -> None:
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

    def residual(self, edge: Edge) -> NDArray[np.float64]:
        """Return `x, y, theta` of the pose of `j` in `i` less the measurement, `(3,) float64`."""
        actual = self.pose(edge.i).inverse() @ self.pose(edge.j)
        error = actual.array() - edge.T_i_j.array()
        error[2] = np.remainder(error[2] + np.pi, 2.0 * np.pi) - np.pi
        return error
