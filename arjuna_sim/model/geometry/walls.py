"""Walls of a world: their surfaces at a height, and the space that they enclose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull

from arjuna_core.arrays import Bools, Floats
from arjuna_sim.model.geometry.shapes import Kind, Part, circle, corners
from arjuna_sim.model.world import World

_EMPTY = np.zeros((0, 4))
_CELL, _CELLS_MAX = 0.05, 600  # of the grid that walls are drawn on [m], and along each side
_NEAR, _EACH = 3000, 10  # cells inside that are looked at, and every how many-th


def surfaces(world: World, height: float) -> Floats:
    """Return where the world's solid parts are cut by a level plane.

    Args:
        height: Of the plane above the ground [m].

    Returns:
        Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m] in the world's frame.
    """
    cuts = [
        _cut(body.part, height)
        for body in world.bodies
        if body.collides and body.part.shape.kind is not Kind.PLANE
    ]
    return np.vstack([_EMPTY, *cuts])


def _cut(part: Part, height: float) -> Floats:
    """Cut one part; of a convex one all lines between corners on either side, then their hull."""
    shape = part.shape
    if shape.kind in (Kind.SPHERE, Kind.ELLIPSOID):
        return _cut_ellipsoid(part, height)
    triangles = shape.triangles()
    if triangles is not None:
        placed = part.pose.apply(triangles.reshape(-1, 3))
        return _cut_triangles(placed.reshape(-1, 3, 3), height)
    outer = part.pose.apply(corners(shape))
    above = outer[:, 2] > height
    if above.all() or not above.any():
        return _EMPTY
    high, low = outer[above][:, None], outer[~above][None]
    ratio = (height - low[..., 2]) / (high[..., 2] - low[..., 2])
    points = (low + ratio[..., None] * (high - low))[..., :2].reshape(-1, 2)
    return _outline(points[ConvexHull(points).vertices])


def _cut_ellipsoid(part: Part, height: float) -> Floats:
    """Cut a ball or an ellipsoid: a unit ball's image, whose own cut is a circle."""
    stretch = part.pose.rotation() * np.array(part.shape.size)
    up = stretch[2]
    length = float(np.linalg.norm(up))
    away = (height - part.pose.position[2]) / length
    if abs(away) >= 1.0:
        return _EMPTY
    normal = up / length
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    ring = circle(math.sqrt(1.0 - away**2)) @ np.array([first, np.cross(normal, first)])
    points = (ring + away * normal) @ stretch.T + np.array(part.pose.position)
    return _outline(points[:, :2])


def _cut_triangles(triangles: Floats, height: float) -> Floats:
    """Cut faces one by one: a face that crosses the plane has one corner alone on its side."""
    above = triangles[..., 2] > height
    count = above.sum(axis=1)
    crossing = (count == 1) | (count == 2)
    faces, alone = triangles[crossing], above[crossing] == (count[crossing] == 1)[:, None]
    tip = np.argmax(alone, axis=1)
    rows = np.arange(len(faces))
    a, ends = faces[rows, tip], []
    for step in (1, 2):
        b = faces[rows, (tip + step) % 3]
        ratio = (height - a[:, 2]) / (b[:, 2] - a[:, 2])
        ends.append((a + ratio[:, None] * (b - a))[:, :2])
    return np.hstack(ends)


def _outline(corners: Floats) -> Floats:
    """Join corners to a closed line, `(N, 2)` to `(N, 4)`."""
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


@dataclass(frozen=True)
class Enclosure:
    """The largest space that walls enclose.

    Attributes:
        origin: The lower left corner of the grid's first cell, `(2,) float64` [m].
        cell: A cell's side [m].
        inside: Whether the middle of a robot may be there, by row (y) and column (x).
        outside: Whether it is outside all walls.
    """

    origin: Floats
    cell: float
    inside: Bools
    outside: Bools

    def is_outside(self, x: float, y: float) -> bool:
        """Return whether a point [m] is outside all walls."""
        column, row = np.floor((np.array([x, y]) - self.origin) / self.cell).astype(int).tolist()
        rows, columns = self.outside.shape
        return not (0 <= row < rows and 0 <= column < columns) or bool(self.outside[row, column])

    def nearest_inside(self, x: float, y: float) -> Floats:
        """Return some points inside, the nearest to a point [m] first, `(N, 2) float64` [m]."""
        points = (np.argwhere(self.inside)[:, ::-1] + 0.5) * self.cell + self.origin
        nearest = np.argsort(np.hypot(*(points - (x, y)).T), kind="stable")[:_NEAR:_EACH]
        return points[nearest]


def enclosure_of(segments: Floats, radius: float) -> Enclosure | None:
    """Return what walls close off for a robot; None where they enclose too little to be a world.

    Args:
        segments: Surfaces of the walls, `(N, 4) float64` of `(x0, y0, x1, y1)` [m].
        radius: Of the robot, which passes no narrower gap than twice that [m].
    """
    if not len(segments):
        return None
    points = segments.reshape(-1, 2)
    size = np.ptp(points, axis=0)
    cell = max(_CELL, float(size.max()) / _CELLS_MAX)
    # Three free cells lie outside the walls, all around.
    margin = radius + 3 * cell
    origin = points.min(axis=0) - margin
    columns, rows = np.ceil((size + 2.0 * margin) / cell).astype(int).tolist()
    walls = np.zeros((rows, columns), np.bool_)
    ends = segments.reshape(-1, 2, 2)
    counts = (np.hypot(*(ends[:, 1] - ends[:, 0]).T) / cell * 2.0).astype(int) + 2
    each = np.repeat(np.arange(len(ends)), counts)
    along = (np.arange(len(each)) - np.repeat(np.cumsum(counts) - counts, counts)) / (
        counts[each] - 1
    )
    at = ends[each, 0] + along[:, None] * (ends[each, 1] - ends[each, 0])
    index = ((at - origin) / cell).astype(int)
    walls[index[:, 1], index[:, 0]] = True
    free = ndimage.distance_transform_edt(~walls) * cell > radius
    labels, _ = ndimage.label(free)
    outside = labels == labels[0, 0]
    sizes = np.bincount(labels[free & ~outside], minlength=1)
    # An enclosure takes at least 0.3 of the grid: else it is a room beside the open.
    if not len(sizes) or sizes.max() < 0.3 * walls.size:
        return None
    return Enclosure(origin, cell, labels == sizes.argmax(), outside)
