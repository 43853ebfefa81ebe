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


_COLUMNS: tuple[tuple[tuple[int, ...], type[Any]], ...] = (
    *(((), np.int64), ((), np.int64), ((3,), np.float64)),
    *(((3, 3), np.float64), ((3, 3), np.float64), ((), np.bool_)),
)
"""Shapes and types of a row of an `EdgeTable`."""


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """The measurements as columns, for the optimiser."""

    i: Ints  # first node of each edge, `(E,) int64`
    j: Ints  # second node of each edge, `(E,) int64`
    measured: Floats  # x, y, theta, `(E, 3) float64` [m, m, rad]
    information: Floats  # of each edge, `(E, 3, 3) float64`
    covariance: Floats  # of each edge, `(E, 3, 3) float64`
    loop: Bools  # which edges close loops, `(E,) bool`

    def __len__(self) -> int:
        """Return the number of edges."""
        return len(self.i)

    @staticmethod
    def of(edges: Iterable[Edge]) -> EdgeTable:
        """Return the table of some edges."""
        return EdgeTable(*(column.values for column in _columns(edges)))


def _columns(edges: Iterable[Edge]) -> tuple[_Column, ...]:
    columns = tuple(_Column(*each) for each in _COLUMNS)
    for edge in edges:
        _append(columns, edge)
    return columns


def _append(columns: tuple[_Column, ...], edge: Edge) -> None:
    own, beside = edge.information, _VAGUE if edge.prior is None else edge.prior
    row = edge.i, edge.j, edge.T_i_j.array(), own, invert(own + beside), edge.kind is EdgeKind.LOOP
    for column, value in zip(columns, row, strict=True):
        column.append(value)


class PoseGraph:
    """Nodes and the measurements between them."""

    def __init__(self) -> None:
        self._poses = _Column((3,))
        self.edges: list[Edge] = []
        self._columns = _columns(())

    def __len__(self) -> int:
        """Return the number of nodes."""
        return self._poses.count

    @property
    def table(self) -> EdgeTable:
        """The measurements as columns."""
        return EdgeTable(*(column.values for column in self._columns))

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
        _append(self._columns, edge)

    def remove_edges(self, unwanted: Bools) -> None:
        """Take some measurements back, `(E,) bool`."""
        self.edges = [
            edge for edge, gone in zip(self.edges, unwanted.tolist(), strict=True) if not gone
        ]
        self._columns = _columns(self.edges)

    def residual(self, edge: Edge) -> Floats:
        """Return `x, y, theta` of the pose of `j` in `i` less the measurement, `(3,) float64`."""
        actual = self.pose(edge.i).inverse() @ self.pose(edge.j)
        error = actual.array() - edge.T_i_j.array()
        error[2] = np.remainder(error[2] + np.pi, 2.0 * np.pi) - np.pi
        return error
