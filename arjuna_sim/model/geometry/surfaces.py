"""The true surfaces of a world at a height."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_sim.model.geometry.shapes import Kind, Part, circle, corners
from arjuna_sim.model.world import World

_EMPTY = np.zeros((0, 4))


def surfaces(world: World, height: float) -> NDArray[np.float64]:
    """Return where the world's solid parts are cut by a level plane.

    Args:
        world: The world.
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


def _cut(part: Part, height: float) -> NDArray[np.float64]:
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


def _cut_ellipsoid(part: Part, height: float) -> NDArray[np.float64]:
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


def _cut_triangles(triangles: NDArray[np.float64], height: float) -> NDArray[np.float64]:
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


def _outline(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Join corners to a closed line, `(N, 2)` to `(N, 4)`."""
    return np.hstack([corners, np.roll(corners, -1, axis=0)])
