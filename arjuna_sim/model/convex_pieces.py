"""Convex pieces of meshes: MuJoCo's contacts take every mesh as its convex hull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

_DEPTH = 0.05  # of the slab behind a face: stops what is slower than 12 m/s at 4 ms a step [m]
_FLAT = 1e-3  # MuJoCo refuses meshes without volume [m]
_FILLED = 0.97  # a body that fills so much of its hull counts as convex
# Beyond these a scene takes seconds to compile.
_FACES_MAX = 2000
_BODIES_MAX = 2000
_PIECES_MAX = 5000
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
"""Corners of a cube about the origin, edges 2, `(8, 3) int64`."""


def hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the convex hull of points; what is flat gets a little depth.

    Args:
        points: `(N, 3) float64` [m].

    Returns:
        `(M, 3) float64` [m], M at least 4.
    """
    points = np.unique(points, axis=0)
    span = points.max(axis=0) - points.min(axis=0)
    try:
        if len(points) < 4 or span.min() < _FLAT:
            raise QhullError("flat")
        return np.asarray(points[ConvexHull(points).vertices], np.float64)
    except QhullError:
        low, high = points.min(axis=0), points.max(axis=0)
        thick = np.maximum(high - low, _FLAT) / 2
        box: NDArray[np.float64] = (low + high) / 2 + CUBE * thick
        return box


def pieces(triangles: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Split a mesh into convex pieces that together are touched like it.

    Connected bodies that nearly fill their hull become it; of others each triangle becomes a
    slab behind its face. Beyond 2000 such triangles a body counts as its hull, as does a mesh of
    more than 2000 bodies, and what comes after 5000 pieces.

    Args:
        triangles: `(N, 3, 3) float64` [m].

    Returns:
        The corners of each piece, `(M, 3) float64` [m].
    """
    found: list[NDArray[np.float64]] = []
    bodies = _bodies(triangles)
    if len(bodies) > _BODIES_MAX:
        return [hull(triangles.reshape(-1, 3))]
    for body in bodies:
        corners = hull(body.reshape(-1, 3))
        is_much = len(body) > _FACES_MAX or len(found) + len(body) > _PIECES_MAX
        if is_much or _volume(body) >= _FILLED * ConvexHull(corners).volume:
            found.append(corners)
        else:
            found.extend(_slabs(body))
    return found


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
