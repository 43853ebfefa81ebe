"""Shapes of bodies, as URDF and SDF have them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.geometry.convex_pieces import CUBE, Pieces, hull, pieces

_ROUND = 64  # corners that stand for a circle
_TILTS = (math.pi / 8, math.pi / 4, 3 * math.pi / 8, math.pi / 2)  # rings of a capsule's ends
GREY = (0.7, 0.7, 0.7, 1.0)


class Kind(Enum):
    """What a shape is."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    CAPSULE = "capsule"
    ELLIPSOID = "ellipsoid"
    PLANE = "plane"
    TERRAIN = "terrain"
    MESH = "mesh"


class Group(Enum):
    """MuJoCo geom groups: what rays hit and what is drawn is chosen by group."""

    WORLD_COLLISION = 0
    WORLD_VISUAL = 1
    ROBOT_VISUAL = 2
    ROBOT_COLLISION = 3
    WORLD_CONTACT = 4


@dataclass(frozen=True, eq=False)
class Mesh:
    """The triangles of a file, `(N, 3, 3) float64` in the file's units."""

    path: Path
    triangles: NDArray[np.float64]
    _hulls: dict[tuple[float, ...], NDArray[np.float64]] = field(default_factory=dict)
    _pieces: dict[tuple[float, ...], Pieces] = field(default_factory=dict)

    @cached_property
    def reach(self) -> float:
        """The largest of its coordinates."""
        return float(np.abs(self.triangles).max())

    def hull(self, scale: tuple[float, ...]) -> NDArray[np.float64]:
        """Return the corners of its convex hull at a scale, `(N, 3) float64` [m]."""
        if scale not in self._hulls:
            self._hulls[scale] = hull(self.triangles.reshape(-1, 3) * np.array(scale))
        return self._hulls[scale]

    def pieces(self, scale: tuple[float, ...], most: int) -> Pieces:
        """Return the convex pieces that it is touched as at a scale.

        Args:
            scale: Along x, y and z.
            most: How many there may be.
        """
        key = (*scale, float(most))
        if key not in self._pieces:
            self._pieces[key] = pieces(self.triangles * np.array(scale), most)
        return self._pieces[key]


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights of a ground that is not level.

    Attributes:
        path: The file.
        heights: From 0 to 1, `(rows, columns) float64`, rows along y and columns along x.
    """

    path: Path
    heights: NDArray[np.float64]

    def points(self, size: tuple[float, ...]) -> NDArray[np.float64]:
        """Return the ground's points in its own frame, `(rows, columns, 3) float64` [m]."""
        rows, columns = self.heights.shape
        x = np.linspace(-size[0] / 2, size[0] / 2, columns)
        y = np.linspace(-size[1] / 2, size[1] / 2, rows)
        return np.stack((*np.meshgrid(x, y), self.heights * size[2]), axis=-1)

    def triangles(self, size: tuple[float, ...]) -> NDArray[np.float64]:
        """Return the ground's faces, `(N, 3, 3) float64` [m]."""
        grid = self.points(size)
        a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
        faces = np.stack((np.stack((a, b, c), axis=-2), np.stack((a, c, d), axis=-2)))
        return faces.reshape(-1, 3, 3)


@dataclass(frozen=True)
class Shape:
    """A shape in its own frame.

    Attributes:
        kind: What it is.
        size: Box: edges (x, y, z). Cylinder, capsule (without its ends): radius, length. Sphere:
            radius. Ellipsoid: radii. Plane: nothing. Mesh: scale (x, y, z). Terrain: extent along
            x and y, and how high white is. All [m].
        mesh: The triangles of a mesh.
        terrain: The heights of a terrain.
    """

    kind: Kind
    size: tuple[float, ...] = ()
    mesh: Mesh | None = None
    terrain: Terrain | None = None

    def triangles(self) -> NDArray[np.float64] | None:
        """Return the faces of a mesh or terrain in its own frame, `(N, 3, 3) float64` [m]."""
        if self.terrain is not None:
            return self.terrain.triangles(self.size)
        return None if self.mesh is None else self.mesh.triangles * np.array(self.size)


@dataclass(frozen=True)
class Part:
    """A shape at a place.

    Attributes:
        shape: The shape.
        pose: Its pose in its link or world.
        rgba: Its colour, 0..1.
        friction: Coefficient of dry friction; None where its file names none.
    """

    shape: Shape
    pose: Pose3 = ORIGIN
    rgba: tuple[float, ...] = GREY
    friction: float | None = None


def corners(shape: Shape) -> NDArray[np.float64]:
    """Return points whose hull is a shape's, in its own frame, `(N, 3) float64` [m].

    Circles have 64 corners; spheres and ellipsoids are stood for by their bounding box, a plane by
    nothing.
    """
    if shape.kind is Kind.PLANE:
        return np.zeros((0, 3))
    if shape.kind is Kind.MESH:
        assert shape.mesh is not None
        return shape.mesh.hull(shape.size)
    if shape.kind is Kind.TERRAIN:
        assert shape.terrain is not None
        return shape.terrain.points(shape.size).reshape(-1, 3)
    if shape.kind in (Kind.CYLINDER, Kind.CAPSULE):
        radius, length = shape.size
        rings = [(radius, sign * length / 2) for sign in (-1, 1)]
        if shape.kind is Kind.CAPSULE:
            rings += [
                (radius * math.cos(tilt), sign * (length / 2 + radius * math.sin(tilt)))
                for tilt in _TILTS
                for sign in (-1, 1)
            ]
        return np.vstack([np.column_stack((circle(r), np.full(_ROUND, z))) for r, z in rings])
    size = {Kind.BOX: shape.size, Kind.ELLIPSOID: tuple(2 * r for r in shape.size)}.get(
        shape.kind, (2 * shape.size[0],) * 3
    )
    result: NDArray[np.float64] = CUBE * np.array(size) / 2
    return result


def circle(radius: float) -> NDArray[np.float64]:
    """Return points on a circle about the origin, `(64, 2) float64` [m]."""
    angles = np.arange(_ROUND) * 2.0 * math.pi / _ROUND
    ring: NDArray[np.float64] = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return ring
