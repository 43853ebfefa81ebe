"""The side of a mesh's faces that is solid, and how thick it is there."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from arjuna_core.arrays import Bools, Floats, Ints

_Triple = tuple[float, float, float]
_CORNER = 0.998  # of the way from a face's middle to its corner the ray of that corner begins


def groups(labels: Ints) -> list[Ints]:
    """Return the indices of the items of each label, by label."""
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)


def numbered(pairs: Ints, count: int) -> Ints:
    """Return a number for each item, the same for those that pairs `(P, 2)` join."""
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def joined(pairs: Ints, count: int) -> list[Ints]:
    """Return the groups of items that pairs `(P, 2)` join, in the order of their first ones."""
    return groups(numbered(pairs, count))


def edges(faces: Ints) -> tuple[Ints, Bools, bool]:
    """Find the edges that two faces share.

    Args:
        faces: Indices of corners, `(N, 3) int64`.

    Returns:
        The two faces of each, `(E, 2) int64`; whether both go along it in one direction, as faces
        that look to one side do not, `(E,) bool`; and whether no edge is a rim.
    """
    directed = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    low, high = directed.min(axis=1), directed.max(axis=1)
    order = np.lexsort((high, low))
    ends = np.stack((low[order], high[order]), axis=1)
    starts = np.flatnonzero(np.diff(ends, axis=0, prepend=-1).any(axis=1))
    counts = np.diff(starts, append=len(order))
    pairs = order[starts[counts == 2][:, None] + np.arange(2)]
    alike = directed[pairs[:, 0], 0] == directed[pairs[:, 1], 0]
    return pairs // 3, alike, bool((counts % 2 == 0).all())


def outward(triangles: Floats, pairs: Ints, alike: Bools, is_closed: bool) -> Floats:
    """Return faces that edges join, each with its corners in the order that has it look outward.

    Neighbours look to one side: outward where they enclose something, else as most of them did.

    Args:
        triangles: `(N, 3, 3) float64` [m].
        pairs: The two faces at each edge, `(E, 2) int64`.
        alike: Whether one of the two is turned, `(E,) bool`; see `edges`.
        is_closed: Whether they enclose something.
    """
    count = len(triangles)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    odd = {(int(a), int(b)) for a, b in np.concatenate((pairs[alike], pairs[alike, ::-1]))}
    turned = np.zeros(count, np.bool_)
    if odd:
        order, before = breadth_first_order(graph.tocsr(), 0, directed=False)
        for face in order[1:].tolist():
            last = int(before[face])
            turned[face] = turned[last] != ((last, face) in odd)
    sign = np.where(turned, -1.0, 1.0)
    crossed = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    if is_closed:
        middles = triangles.mean(axis=1)
        agree = sign @ np.einsum("ij,ij->i", middles - middles.mean(axis=0), crossed)
    else:
        agree = sign @ np.linalg.norm(crossed, axis=1)
    return np.where((turned ^ (agree < 0.0))[:, None, None], triangles[:, ::-1], triangles)


def depths(triangles: Floats, normals: Floats, most: float) -> Floats:
    """Return how deep a closed body is behind each corner of its faces, `(N, 3) float64` [m].

    Args:
        triangles: `(N, 3, 3) float64` that look outward [m].
        normals: The unit vectors along which they look, `(N, 3) float64`.
        most: What is deeper counts as so deep [m].
    """
    middle = triangles.mean(axis=1, keepdims=True)
    starts = np.concatenate((middle + _CORNER * (triangles - middle), middle), axis=1)
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    axis = int(np.argmax(np.ptp(middle[:, 0], axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    longest = float((high - low)[:, axis].max(initial=0.0))
    found = np.empty((len(triangles), 4))
    found[order] = _lengths(
        triangles[order],
        normals[order],
        low[order],
        high[order],
        starts[order],
        axis,
        longest,
        most,
    )
    # Where the middle is thinner than the corners, as above a notch, all are.
    return np.minimum(found[:, :3], found[:, 3:])


@njit(cache=True, error_model="numpy")
def _lengths(
    triangles: Floats,
    normals: Floats,
    low: Floats,
    high: Floats,
    starts: Floats,
    axis: int,
    longest: float,
    most: float,
) -> Floats:
    """Return how far rays go back from faces until they hit another, `(N, K) float64`.

    Args:
        triangles: In the order of `low` along the axis, `(N, 3, 3)`.
        normals: Theirs, `(N, 3)`.
        low: Their least coordinates, `(N, 3)`.
        high: Their greatest, `(N, 3)`.
        starts: Of the rays of each face, `(N, K, 3)`.
        longest: The greatest extent of a face along the axis.
        most: The length of a ray.
    """
    count, rays = starts.shape[:2]
    found = np.full((count, rays), most)
    for i in range(count):
        u, v, w = normals[i]
        for k in range(rays):
            start, end = starts[i, k], starts[i, k] - most * normals[i]
            first, last = np.minimum(start, end), np.maximum(start, end)
            for j in range(np.searchsorted(low[:, axis], first[axis] - longest), count):
                if low[j, axis] > last[axis]:
                    break
                if j == i or _is_apart(low[j], high[j], first, last):
                    continue
                a, b, c = normals[j]
                along = -(a * u + b * v + c * w)
                if along == 0.0:
                    continue
                x, y, z = triangles[j, 0]
                x, y, z = x - start[0], y - start[1], z - start[2]
                length = (a * x + b * y + c * z) / along
                if 0.0 <= length < found[i, k]:
                    point = start[0] - length * u, start[1] - length * v, start[2] - length * w
                    if _is_in(triangles[j], (a, b, c), point):
                        found[i, k] = length
    return found


@njit(cache=True)
def _is_apart(low: Floats, high: Floats, first: Floats, last: Floats) -> bool:
    """Return whether two boxes along the axes, of least and greatest corners, have no point."""
    return bool(
        high[0] < first[0]
        or low[0] > last[0]
        or high[1] < first[1]
        or low[1] > last[1]
        or high[2] < first[2]
        or low[2] > last[2]
    )


@njit(cache=True)
def _is_in(face: Floats, normal: _Triple, point: _Triple) -> bool:
    """Return whether a point of a face's plane is in the face."""
    for i in range(3):
        a, b, c = face[i]
        d, e, f = face[(i + 1) % 3]
        d, e, f = d - a, e - b, f - c
        a, b, c = point[0] - a, point[1] - b, point[2] - c
        x, y, z = e * c - f * b, f * a - d * c, d * b - e * a
        if x * normal[0] + y * normal[1] + z * normal[2] < 0.0:
            return False
    return True
