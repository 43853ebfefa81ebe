"""Pose graphs of g2o and TORO files, and their optimisation from a start that may be far off."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import splu

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_slam.graph.optimizer import OptimizerResult, chi2, optimize
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, EdgeTable

_VERTICES = ("VERTEX_SE2", "VERTEX2")
_UPPER = {  # positions of the six numbers in the upper triangle
    "EDGE_SE2": ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
    "EDGE2": ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2)),
}


def read_graph(path: str | Path) -> tuple[NDArray[np.float64], EdgeTable]:
    """Read a planar pose graph.

    Args:
        path: A g2o (`VERTEX_SE2`, `EDGE_SE2`) or TORO file (`VERTEX2`, `EDGE2`).

    Returns:
        Poses `(N, 3) float64` in the order of their ids, from the edges alone where the file holds
        no vertex, and the edges.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputFileError(path, f"cannot be read: {error}") from error
    poses: dict[int, tuple[float, ...]] = {}
    edges: list[tuple[int, int, SE2, NDArray[np.float64]]] = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        try:
            if words and words[0] in _VERTICES:
                poses[int(words[1])] = _numbers(words[2:], 3)
            elif words and words[0] in _UPPER:
                edges.append(_edge(words))
        except ValueError as error:
            raise InputFileError(path, str(error), f"line {number}") from error
    if not edges:
        raise InputFileError(path, "has no edges")
    named = {name for i, j, _, _ in edges for name in (i, j)}
    if poses and (missing := named - poses.keys()):
        raise InputFileError(path, f"nodes {sorted(missing)[:5]} have no vertex")
    order = {name: k for k, name in enumerate(sorted(poses or named))}
    table = EdgeTable.of(
        Edge(order[i], order[j], pose, information, EdgeKind.LOOP)
        for i, j, pose, information in edges
    )
    if not poses:
        return initialize(np.zeros((len(order), 3)), table), table
    return np.array([poses[name] for name in order]), table


def _numbers(words: list[str], count: int) -> tuple[float, ...]:
    values = tuple(float(word) for word in words[:count])
    if len(words) < count or not all(math.isfinite(value) for value in values):
        raise ValueError(f"{count} finite numbers are valid, got {' '.join(words)!r}")
    return values


def _edge(words: list[str]) -> tuple[int, int, SE2, NDArray[np.float64]]:
    values = _numbers(words[3:], 9)
    information = np.empty((3, 3))
    for (row, column), value in zip(_UPPER[words[0]], values[3:], strict=True):
        information[row, column] = information[column, row] = value
    measured = SE2(*values[:3])
    turn = SE2(0.0, 0.0, measured.theta).matrix()  # the files' is in the axes of the second node
    return int(words[1]), int(words[2]), measured, turn @ information @ turn.T


_REGULAR = 1e-12  # share of the greatest weight; holds what no edge joins to node 0


def optimize_globally(
    poses: NDArray[np.float64], edges: EdgeTable, *, iterations: int = 100
) -> OptimizerResult:
    """Return the poses of least cost, the first held, from the better of two starts.

    A graph that then still disagrees with itself may be in a local minimum: the other start is
    tried as well.

    Args:
        poses: Start, `(N, 3) float64` of x, y, theta [m, m, rad].
        edges: The measurements; they must connect all nodes.
        iterations: Most steps from each start.
    """
    if not len(edges) or len(poses) < 2:
        return optimize(poses, edges)
    starts = sorted((poses, initialize(poses, edges)), key=lambda start: cost(start, edges))
    result = optimize(starts[0], edges, iterations=iterations)
    if result.trace[-1] <= 3.0 * (len(edges) - len(poses) + 1):
        return result
    other = optimize(starts[1], edges, iterations=iterations)
    return min(result, other, key=lambda found: found.trace[-1])


def cost(poses: NDArray[np.float64], edges: EdgeTable) -> float:
    """Return the sum of the edges' chi2."""
    i, j = np.ascontiguousarray(edges.i), np.ascontiguousarray(edges.j)
    return float(chi2(poses, i, j, edges.measured, edges.information).sum())


def initialize(poses: NDArray[np.float64], edges: EdgeTable) -> NDArray[np.float64]:
    """Return poses that fit the edges, as a start for the optimiser.

    Args:
        poses: `(N, 3) float64` [m, m, rad]; only the first counts, and stays.
    """
    i, j, count, first = edges.i, edges.j, len(poses), poses[0]
    weight = edges.information[:, 2, 2]
    turn = np.exp(1j * edges.measured[:, 2])
    heading = _solve(
        count, i, j, weight, turn, np.zeros(len(i), np.complex128), np.exp(1j * first[2])
    )
    direction = heading / np.maximum(np.abs(heading), 1e-12)
    step = direction[i] * (edges.measured[:, 0] + 1j * edges.measured[:, 1])
    spread = 0.5 * (edges.information[:, 0, 0] + edges.information[:, 1, 1])
    solved = _solve(
        count, i, j, spread, np.ones(len(i), np.complex128), step, complex(first[0], first[1])
    )
    return np.column_stack((solved.real, solved.imag, np.angle(direction)))


def _solve(
    count: int,
    i: NDArray[np.int64],
    j: NDArray[np.int64],
    weight: NDArray[np.float64],
    factor: NDArray[np.complex128],
    offset: NDArray[np.complex128],
    first: complex,
) -> NDArray[np.complex128]:
    """Return z of least sum weight |z_j - factor z_i - offset|^2 with z_0 given."""
    rows = np.concatenate((i, j, i, j))
    columns = np.concatenate((i, j, j, i))
    across = -weight * factor
    values = np.concatenate((weight * np.abs(factor) ** 2, weight, np.conj(across), across))
    links = coo_matrix((values, (rows, columns)), shape=(count, count))
    matrix = (links + _REGULAR * weight.max() * identity(count)).tocsc()
    right = np.zeros(count, np.complex128)
    np.add.at(right, j, weight * offset)
    np.add.at(right, i, -weight * np.conj(factor) * offset)
    right = right[1:] - matrix[1:, 0].toarray().ravel() * first
    free = splu(
        matrix[1:, 1:], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    ).solve(right)  # fmt: skip
    return np.concatenate(([first], free))
