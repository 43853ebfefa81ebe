"""Convex pieces of meshes: MuJoCo's contacts take every mesh as its convex hull."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from arjuna_core.arrays import Floats, Ints
from arjuna_core.files.array_cache import cached, made_by
from arjuna_sim.model.geometry import thickness
from arjuna_sim.model.geometry.thickness import depths, edges, joined, outward

PIECES_MAX = 5000
"""Greatest number of pieces of a fast mesh: beyond, a scene takes seconds to compile."""
PIECES_OF_MOVING = 24
"""The same of a mesh that can be pushed: each may touch the ground in four points."""
_DEPTH = 0.05  # of the slab behind a face: stops what is slower than 12 m/s at 4 ms a step [m]
_SHEET = 1.5e-3  # that of a face behind which there is nothing [m]
_FLAT = 1e-3  # MuJoCo refuses meshes without volume [m]
_TESTS = 20_000_000  # of points against a hull's planes at the most: a second
_SLIVER = 1e-5  # the height of a face that is not felt [m]
_OFF = (2e-3, 1e-2)  # how deep hollows may be that are filled, if it makes few enough pieces [m]
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
"""Corners of a cube about the origin, edges 2, `(8, 3) int64`."""


@dataclass(frozen=True)
class Pieces:
    """Convex pieces that together stand for a mesh.

    Attributes:
        corners: Of each piece, `(M, 3) float64` [m].
        within: How far they may lie off the mesh; 0 where they follow it [m].
    """

    corners: list[Floats]
    within: float = 0.0


def hull(points: Floats) -> Floats:
    """Return the corners of the convex hull of points; what is flat gets a little depth.

    Args:
        points: `(N, 3) float64` [m].

    Returns:
        `(M, 3) float64` [m], M at least 4.
    """
    return hulls(points, np.array([len(points)]))[0]


def hulls(points: Floats, counts: Ints) -> list[Floats]:
    """Return the corners of the convex hulls of groups of points, each as `hull` makes it.

    Args:
        points: Of one group after the other, `(N, 3) float64` [m].
        counts: How many each group has, `(G,) int64`.
    """
    starts = np.cumsum(counts) - counts
    middles = np.add.reduceat(points, starts) / counts[:, None]
    # The axes along which the points spread, the narrowest last (principal component analysis).
    away = points - middles.repeat(counts, axis=0)
    spread = np.add.reduceat(away[:, :, None] * away[:, None], starts)
    axes = np.linalg.eigh(spread)[1].transpose(0, 2, 1)[:, ::-1]
    local = (axes.repeat(counts, axis=0) @ away[:, :, None])[:, :, 0]
    low, high = np.minimum.reduceat(local, starts), np.maximum.reduceat(local, starts)
    found = []
    for i, (start, count) in enumerate(zip(starts.tolist(), counts.tolist(), strict=True)):
        some = slice(start, start + count)
        span = high[i] - low[i]
        try:
            if count >= 4 and span[2] >= _FLAT:
                found.append(points[some][_corners(points[some])])
                continue
            flat = local[some, :2]
            rim = flat[_corners(flat)] if span[1] >= _FLAT else None
        except QhullError:
            rim = None
        if rim is None:
            plate = (low[i] + high[i]) / 2 + CUBE * np.maximum(span, _FLAT) / 2
        else:
            thick = np.full((len(rim), 1), max(span[2], _FLAT) / 2)
            plate = np.vstack((np.hstack((rim, -thick)), np.hstack((rim, thick))))
        found.append(plate @ axes[i] + middles[i])
    return found


def _corners(points: Floats) -> Ints:
    """Return which points are corners of the hull of all; scipy takes as long as Qhull for it."""
    return np.flatnonzero(np.bincount(ConvexHull(points).simplices.ravel()))


def pieces(triangles: Floats, most: int = PIECES_MAX) -> Pieces:
    """Split a mesh into convex pieces that together are touched like it.

    Connected bodies that are closed and without hollows become their hull; of others each face
    becomes a slab behind it, as deep as the body is there. Where that makes too many, the faces are
    sorted into the cells of a grid, as fine as it may be, and each cell's faces become their hull.

    Args:
        triangles: `(N, 3, 3) float64` [m].
    """
    # The search for the bodies of more faces takes seconds.
    if len(triangles) > 50_000:
        return _of_cells(triangles, most)
    bodies = _bodies(triangles)
    for off in _OFF if len(bodies) <= most else ():
        found: list[Floats] = []
        for body in bodies:
            if body.fills(off):
                found.append(body.hull)
            elif len(found) + len(body.levels) <= most:
                found.extend(body.slabs)
            else:
                break
        else:
            if 0 < len(found) <= most:
                return Pieces(found, off if off > _OFF[0] else 0.0)
    return _of_cells(triangles, most)


def kept_pieces(triangles: Floats, most: int) -> Pieces:
    """Return what `pieces` returns, from the user's cache where the mesh was split before."""

    def split() -> tuple[Floats, ...]:
        made = pieces(triangles, most)
        counts = np.array([len(corners) for corners in made.corners])
        return np.concatenate(made.corners), counts, np.array(made.within)

    made_of = made_by(__file__, thickness.__file__), triangles.tobytes(), str(most).encode()
    corners, counts, within = cached("pieces", made_of, split)
    return Pieces(np.split(corners, np.cumsum(counts)[:-1]), float(within))


class _Body:
    """Faces that share edges.

    Attributes:
        triangles: That look outward, `(N, 3, 3) float64` [m].
    """

    def __init__(self, triangles: Floats, faces: Ints) -> None:
        self._pairs, alike, self._is_closed = edges(faces)
        self.triangles = outward(triangles, self._pairs, alike, self._is_closed)
        self._normals, self._heights = _normals(self.triangles)

    @cached_property
    def hull(self) -> Floats:
        """The corners of its convex hull, `(M, 3) float64` [m]."""
        return hull(self.triangles.reshape(-1, 3))

    def fills(self, off: float) -> bool:
        """Return whether it is closed, and fills its hull but for hollows not deeper than this."""
        if not self._is_closed or not len(self._hollows):
            return self._is_closed
        planes = ConvexHull(self.hull).equations
        points = self._hollows[:: 1 + len(self._hollows) * len(planes) // _TESTS]
        for some in np.array_split(points, 1 + len(points) * len(planes) // 1_000_000):
            if np.any(np.max(some @ planes[:, :3].T + planes[:, 3], axis=1) < -off):
                return False
        return True

    @cached_property
    def _hollows(self) -> Floats:
        """Points of the faces whose neighbours rise before them, `(H, 3)`; none if it is convex."""
        middles = self.triangles.mean(axis=1)
        first, second = self._pairs.T
        rises = (
            np.einsum("ij,ij->i", self._normals[first], middles[second] - middles[first]) > _SLIVER
        )
        faces = np.unique(self._pairs[rises])
        sides = (self.triangles + np.roll(self.triangles, 1, axis=1)) / 2
        return np.concatenate(
            (middles[faces, None], self.triangles[faces], sides[faces]), axis=1
        ).reshape(-1, 3)

    @cached_property
    def levels(self) -> list[Ints]:
        """Its faces but slivers, level ones together where their outline is convex."""
        normals = self._normals
        first, second = self._pairs.T
        is_level = np.einsum("ij,ij->i", normals[first], normals[second]) > 1.0 - 1e-9
        found = []
        for group in joined(self._pairs[is_level], len(normals)):
            whole = len(group) == 1 or _is_convex(self.triangles[group])
            found += [group] if whole else list(group[:, None])
        return [group for group in found if self._heights[group].max() > _SLIVER]

    @cached_property
    def slabs(self) -> list[Floats]:
        """The solids behind the levels, as deep as the body is there, `(M, 3)` [m]."""
        depth = np.full(self.triangles.shape[:2], _SHEET)
        if self._is_closed:
            depth = depths(self.triangles, self._normals, _DEPTH)
            depth[depth.max(axis=1) < _FLAT] = _FLAT
        backs = self.triangles - depth[..., None] * self._normals[:, None]
        found = []
        for group in self.levels:
            points = np.stack((self.triangles[group], backs[group]), axis=1)
            if len(group) == 1 or np.ptp(depth[group]) > _FLAT:
                found += list(points.reshape(-1, 6, 3))
            else:
                found.append(hull(points.reshape(-1, 3)))
        return found


def _normals(triangles: Floats) -> tuple[Floats, Floats]:
    """Return the unit vectors that faces look along, `(N, 3)`, and their least heights [m]."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    crossed = np.cross(sides[:, 0], sides[:, 1])
    doubled = np.linalg.norm(crossed, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    return crossed / np.maximum(doubled, 1e-300)[:, None], doubled / np.maximum(longest, 1e-300)


def _is_convex(triangles: Floats) -> bool:
    """Return whether level faces fill the outline of all."""
    flat = hull(triangles.reshape(-1, 3))
    return surface(triangles) >= (1.0 - 1e-6) * float(ConvexHull(flat).volume) / _FLAT


def surface(triangles: Floats) -> float:
    """Return the area of faces `(N, 3, 3) float64` [m^2]."""
    crossed = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return float(np.linalg.norm(crossed, axis=1).sum()) / 2


def _bodies(triangles: Floats) -> list[_Body]:
    """Group triangles that share edges, in the order of their first triangle."""
    scale = max(float(np.abs(triangles).max()), 1e-9)
    rounded = np.round(triangles.reshape(-1, 3) / scale, 6)
    faces = np.unique(rounded, axis=0, return_inverse=True)[1].reshape(-1, 3)
    return [_Body(triangles[each], faces[each]) for each in joined(edges(faces)[0], len(faces))]


def _of_cells(triangles: Floats, most: int) -> Pieces:
    """Return the hulls of what lies in the cells of the finest grid that makes few enough."""
    area = surface(triangles)
    reach = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    side = max(np.sqrt(area / most), reach / 500, 1e-3)
    while side < reach:
        parts = _cut(triangles, side)
        cells = np.floor(parts.mean(axis=1) / side).astype(np.int64)
        cells -= cells.min(axis=0)
        keys = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
        _, cell = np.unique(keys, return_inverse=True)
        if int(cell.max()) < most:
            counts = np.bincount(cell)
            return Pieces(_thick(parts[np.argsort(cell, kind="stable")], counts), float(side))
        # Larger cells make fewer pieces, until these are within their budget.
        side *= 1.25
    return Pieces([hull(triangles.reshape(-1, 3))], reach)


def _cut(triangles: Floats, side: float) -> Floats:
    """Halve faces along their longest edge until none is longer than a side."""
    done: list[Floats] = []
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


def _thick(faces: Floats, counts: Ints) -> list[Floats]:
    """Return the hulls of groups of faces; one that faces one side is as deep as a slab behind it.

    Args:
        faces: Of one group after the other, `(N, 3, 3)` [m].
        counts: How many each group has, `(G,)`.
    """
    starts = np.cumsum(counts) - counts
    crossed = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normals = np.add.reduceat(crossed, starts)
    doubled = np.add.reduceat(np.linalg.norm(crossed, axis=1), starts)
    lengths = np.linalg.norm(normals, axis=1)
    faces_one_side = (doubled > 0.0) & (lengths > 0.97 * doubled)
    back = _SHEET * normals / np.where(faces_one_side, lengths, 1.0)[:, None]
    points = np.stack((faces, faces - back.repeat(counts, axis=0)[:, None]), axis=1)
    is_used = np.stack((np.ones(len(faces), bool), faces_one_side.repeat(counts)), axis=1)
    return hulls(points[is_used].reshape(-1, 3), 3 * counts * (1 + faces_one_side))
