"""The pose graph: keyframe poses and the measurements between them."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


class _Column:
    """An array that grows by rows."""

    def __init__(self, shape: tuple[int, ...], kind: type[Any] = np.float64) -> None:
        self._values = np.empty((64, *shape), kind)
        self.count = 0

    def append(self, row: Any) -> None:
        if self.count == len(self._values):
            self._values = np.concatenate((self._values, np.empty_like(self._values)))
        self._values[self.count] = row
        self.count += 1

    @property
    def values(self) -> NDArray[Any]:
        return self._values[: self.count]


class EdgeTable:
    """The measurements as columns, for the optimiser."""

    def __init__(self) -> None:
        self._i, self._j = _Column((), np.int64), _Column((), np.int64)
        self._measured, self._loop = _Column((3,)), _Column((), np.bool_)
        self._information, self._covariance = _Column((3, 3)), _Column((3, 3))

    def __len__(self) -> int:
        """Return the number of edges."""
        return self._i.count

    @staticmethod
    def of(edges: Iterable[Edge]) -> EdgeTable:
        """Return the table of some edges."""
        table = EdgeTable()
        for edge in edges:
            table.append(edge)
        return table

    def append(self, edge: Edge) -> None:
        """Add an edge."""
        beside = _VAGUE if edge.prior is None else edge.prior
        self._i.append(edge.i)
        self._j.append(edge.j)
        self._measured.append((edge.T_i_j.x, edge.T_i_j.y, edge.T_i_j.theta))
        self._information.append(edge.information)
        self._covariance.append(invert(edge.information + beside))
        self._loop.append(edge.kind is EdgeKind.LOOP)

    @property
    def i(self) -> Ints:
        """First node of each edge, `(E,) int64`."""
        return self._i.values

    @property
    def j(self) -> Ints:
        """Second node of each edge, `(E,) int64`."""
        return self._j.values

    @property
    def measured(self) -> Floats:
        """Measured x, y, theta, `(E, 3) float64` [m, m, rad]."""
        return self._measured.values

    @property
    def information(self) -> Floats:
        """Information of each edge, `(E, 3, 3) float64`."""
        return self._information.values

    @property
    def covariance(self) -> Floats:
        """Covariance of each edge, `(E, 3, 3) float64`."""
        return self._covariance.values

    @property
    def loop(self) -> Bools:
        """Which edges close loops, `(E,) bool`."""
        return self._loop.values


class PoseGraph:
    """Nodes and the measurements between them."""

    def __init__(self) -> None:
        self._poses = _Column((3,))
        self.edges: list[Edge] = []
        self.table = EdgeTable()

    def __len__(self) -> int:
        """Return the number of nodes."""
        return self._poses.count

    @property
    def poses(self) -> Floats:
        """A view of all poses `x, y, theta` in map, `(N, 3) float64` [m, m, rad]."""
        return self._poses.values

    @poses.setter
    def poses(self, values: Floats) -> None:
        self._poses.values[:] = values

    def pose(self, node: int) -> SE2:
        """Return a node's pose in map."""
        return SE2.from_array(self.poses[node])

    def add_node(self, pose: SE2) -> int:
        """Add a node and return its index."""
        self._poses.append(pose.array())
        return len(self) - 1

    def add_edge(self, edge: Edge) -> None:
        """Add a measurement.

        Raises:
            ValueError: A node does not exist or both are the same.
        """
        if not (0 <= edge.i < len(self) and 0 <= edge.j < len(self)) or edge.i == edge.j:
            raise ValueError(
                f"edge {edge.i} -> {edge.j}: two different nodes of 0..{len(self) - 1} are valid"
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
