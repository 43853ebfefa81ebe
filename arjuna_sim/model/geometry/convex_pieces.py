"""Convex pieces of meshes: MuJoCo's contacts take every mesh as its convex hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

PIECES_MAX = 5000
"""Greatest number of pieces of a fast mesh: beyond, a scene takes seconds to compile."""
PIECES_OF_MOVING = 24
"""The same of a mesh that can be pushed: each may touch the ground in four points."""
_DEPTH = 0.05  # of the slab behind a face: stops what is slower than 12 m/s at 4 ms a step [m]
_FLAT = 1e-3  # MuJoCo refuses meshes without volume [m]
_FILLED = 0.97  # a body that fills so much of its hull counts as convex
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
"""Corners of a cube about the origin, edges 2, `(8, 3) int64`."""


@dataclass(frozen=True)
class Pieces:
    """Convex pieces that together stand for a mesh.

    Attributes:
        corners: Of each piece, `(M, 3) float64` [m].
        within: How far they may lie off the mesh; 0 where they follow it [m].
    """

    corners: list[NDArray[np.float64]]
    within: float = 0.0


def hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the convex hull of points; what is flat gets a little depth.

    Args:
        points: `(N, 3) float64` [m].

    Returns:
        `(M, 3) float64` [m], M at least 4.
    """
    points = np.unique(points, axis=0)
    middle = points.mean(axis=0)
    # The axes along which the points spread, the narrowest last (principal component analysis).
    away = points - middle
    axes = np.linalg.eigh(away.T @ away)[1].T[::-1]
    local = away @ axes.T
    span = local.max(axis=0) - local.min(axis=0)
    try:
        if len(points) >= 4 and span[2] >= _FLAT:
            return np.asarray(points[ConvexHull(points).vertices], np.float64)
        rim = local[ConvexHull(local[:, :2]).vertices] if span[1] >= _FLAT else None
    except QhullError:
        rim = None
    if rim is None:
        low, high = local.min(axis=0), local.max(axis=0)
        plate = (low + high) / 2 + CUBE * np.maximum(high - low, _FLAT) / 2
    else:
        thick = np.array([0.0, 0.0, max(span[2], _FLAT) / 2])
        plate = np.vstack((rim * (1, 1, 0) - thick, rim * (1, 1, 0) + thick))
    result: NDArray[np.float64] = plate @ axes + middle
    return result


def pieces(triangles: NDArray[np.float64], most: int = PIECES_MAX) -> Pieces:
    """Split a mesh into convex pieces that together are touched like it.

    Connected bodies that nearly fill their hull become it; of others each triangle becomes a
    slab behind its face. Where that makes too many, the faces are sorted into the cells of a grid,
    as fine as it may be, and each cell's faces become their hull.

    Args:
        triangles: `(N, 3, 3) float64` [m].
    """
    found: list[NDArray[np.float64]] = []
    # The search for connected bodies of more faces takes seconds.
    if len(triangles) > 50_000:
        return _of_cells(triangles, most)
    bodies = _bodies(triangles)
    for body in bodies if len(bodies) <= most else ():
        corners = hull(body.reshape(-1, 3))
        is_convex = _volume(body) >= _FILLED * ConvexHull(corners).volume
        if not is_convex and len(found) + len(body) > most:
            return _of_cells(triangles, most)
        found.extend([corners] if is_convex else _slabs(body))
    if 0 < len(found) <= most:
        return Pieces(found)
    return _of_cells(triangles, most)


def surface(triangles: NDArray[np.float64]) -> float:
    """Return the area of faces `(N, 3, 3) float64` [m^2]."""
    crossed = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return float(np.linalg.norm(crossed, axis=1).sum()) / 2


def _bodies(triangles: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Group triangles that share corners, in the order of their first triangle."""
    scale = max(float(np.abs(triangles).max()), 1e-9)
    rounded = np.round(triangles.reshape(-1, 3) / scale, 6)
    _, corner = np.unique(rounded, axis=0, return_inverse=True)
    faces = corner.reshape(-1, 3)
    rows, columns = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()
    count = int(faces.max()) + 1
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    label = connected_components(graph, directed=False)[1][faces[:, 0]]
    order = np.argsort(label, kind="stable")
    starts = np.flatnonzero(np.diff(label[order], prepend=-1))
    groups = sorted(np.split(order, starts[1:]), key=lambda group: int(group[0]))
    return [triangles[group] for group in groups]


def _volume(triangles: NDArray[np.float64]) -> float:
    """Return the volume that closed faces enclose (divergence theorem) [m^3]."""
    local = triangles - triangles.reshape(-1, 3).mean(axis=0)
    crossed = np.cross(local[:, 1], local[:, 2])
    return abs(float(np.einsum("ij,ij->", local[:, 0], crossed))) / 6.0


def _slabs(triangles: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    kept = doubled > 1e-9  # [m^2] slivers are not felt
    depth = _DEPTH * normals[kept] / doubled[kept, None]
    return [np.vstack([face, face - d]) for face, d in zip(triangles[kept], depth, strict=True)]


def _of_cells(triangles: NDArray[np.float64], most: int) -> Pieces:
    """Return the hulls of what lies in the cells of the finest grid that makes few enough."""
    area = surface(triangles)
    reach = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    side = max(np.sqrt(area / most), reach / 500, 1e-3)
    while side < reach:
        parts = _cut(triangles, side)
        cells = np.floor(parts.mean(axis=1) / side).astype(np.int64)
        _, cell = np.unique(cells, axis=0, return_inverse=True)
        if int(cell.max()) < most:
            order = np.argsort(cell, kind="stable")
            starts = np.flatnonzero(np.diff(cell[order], prepend=-1))
            return Pieces([_thick(parts[g]) for g in np.split(order, starts[1:])], float(side))
        # Larger cells make fewer pieces, until these are within their budget.
        side *= 1.25
    return Pieces([hull(triangles.reshape(-1, 3))], reach)


def _cut(triangles: NDArray[np.float64], side: float) -> NDArray[np.float64]:
    """Halve faces along their longest edge until none is longer than a side."""
    done: list[NDArray[np.float64]] = []
    while len(triangles):
        edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        is_long = edges.max(axis=1) > side
        # Faces are cut into 1e6 parts at most; the others stay longer than a side.
        if sum(len(faces) for faces in done) + 2 * int(is_long.sum()) > 1_000_000:
            is_long[:] = False
        done.append(triangles[~is_long])
        faces, first = triangles[is_long], edges[is_long].argmax(axis=1)
        rows = np.arange(len(faces))
        a, b, c = (faces[rows, (first + i) % 3] for i in range(3))
        middle = (a + b) / 2
        triangles = np.concatenate((np.stack((a, middle, c), 1), np.stack((middle, b, c), 1)))
    return np.concatenate(done)


def _thick(faces: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the hull of faces; those that face one side reach as deep as a slab behind them."""
    points = faces.reshape(-1, 3)
    crossed = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normal, doubled = crossed.sum(axis=0), float(np.linalg.norm(crossed, axis=1).sum())
    if doubled > 0.0 and float(np.linalg.norm(normal)) > _FILLED * doubled:
        points = np.vstack((points, points - _DEPTH * normal / np.linalg.norm(normal)))
    return hull(points)
