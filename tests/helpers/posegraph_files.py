"""Pose graphs of the SLAM community's files: g2o and TORO."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind, EdgeTable
from tests.helpers.posegraph_start import initialize

_VERTICES = ("VERTEX_SE2", "VERTEX2")
_UPPER = {  # places of the six numbers in the upper triangle
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

    Raises:
        InputFileError: The file is missing, a line is broken, or some nodes have no vertex.
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
