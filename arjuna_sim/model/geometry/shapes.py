"""Shapes of bodies, as URDF and SDF have them, and their mass properties."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_core.arrays import Bytes, Floats, Singles
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.geometry.convex_pieces import CUBE, Pieces, hull, kept_pieces, pieces

_ROUND = 64  # corners that stand for a circle
_TILTS = (math.pi / 8, math.pi / 4, 3 * math.pi / 8, math.pi / 2)  # rings of a capsule's ends
GREY = (0.7, 0.7, 0.7, 1.0)
DENSITY = 500.0
"""Of parts whose file gives no mass: half of water's, as robots are hollow [kg/m^3]."""
MASS_MIN = 1e-6
"""Least mass of a link [kg]."""
MASS_MAX = 1e7
"""Greatest mass of a link or model [kg]."""


class Kind(Enum):
    """The kind of a shape."""

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


class Look(NamedTuple):
    """A material of a mesh: its colour, None for none, and the name of its picture."""

    rgba: Sequence[float] | None
    picture: str


class Skin(NamedTuple):
    """The look of a mesh's triangles.

    Attributes:
        places: Where corners are in a picture, from its top, `(N, 3, 2) float32`; NaN for nowhere.
        of: Which look each triangle has, `(N,) int32`.
    """

    places: Singles
    of: NDArray[np.int32]
    looks: tuple[Look, ...]


@dataclass(frozen=True, eq=False)
class Mesh:
    """The triangles of a file, `(N, 3, 3) float64` in the file's units, and their look."""

    path: Path
    triangles: Floats
    skin: Skin | None = None
    _hulls: dict[tuple[float, ...], Floats] = field(default_factory=dict)
    _pieces: dict[tuple[float, ...], Pieces] = field(default_factory=dict)

    @cached_property
    def reach(self) -> float:
        """The largest of its coordinates."""
        return float(np.abs(self.triangles).max())

    def hull(self, scale: tuple[float, ...]) -> Floats:
        """Return the corners of its convex hull at a scale, `(N, 3) float64` [m]."""
        if scale not in self._hulls:
            self._hulls[scale] = hull(self.triangles.reshape(-1, 3) * np.array(scale))
        return self._hulls[scale]

    def pieces(self, scale: tuple[float, ...], most: int) -> Pieces:
        """Return the convex pieces that it is touched as at a scale."""
        key = (*scale, float(most))
        if key not in self._pieces:
            scaled = self.triangles * np.array(scale)
            # Of few triangles they are computed faster than read.
            found = pieces if len(scaled) < 200 else kept_pieces
            self._pieces[key] = found(scaled, most)
        return self._pieces[key]


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights of a ground that is not level.

    Attributes:
        heights: From 0 to 1, `(rows, columns) float64`, rows along y and columns along x.
    """

    path: Path
    heights: Floats

    def points(self, size: tuple[float, ...]) -> Floats:
        """Return the ground's points in its own frame, `(rows, columns, 3) float64` [m]."""
        rows, columns = self.heights.shape
        x = np.linspace(-size[0] / 2, size[0] / 2, columns)
        y = np.linspace(-size[1] / 2, size[1] / 2, rows)
        return np.stack((*np.meshgrid(x, y), self.heights * size[2]), axis=-1)

    def triangles(self, size: tuple[float, ...]) -> Floats:
        """Return the ground's faces, `(N, 3, 3) float64` [m]."""
        grid = self.points(size)
        a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
        faces = np.stack((np.stack((a, b, c), axis=-2), np.stack((a, c, d), axis=-2)))
        return faces.reshape(-1, 3, 3)


@dataclass(frozen=True)
class Shape:
    """A shape in its own frame.

    Attributes:
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

    def triangles(self) -> Floats | None:
        """Return the faces of a mesh or terrain in its own frame, `(N, 3, 3) float64` [m]."""
        if self.terrain is not None:
            return self.terrain.triangles(self.size)
        return None if self.mesh is None else self.mesh.triangles * np.array(self.size)


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture on a shape, `(rows, columns, 3) uint8` RGB, the top row first."""

    path: Path
    pixels: Bytes


@dataclass(frozen=True)
class Part:
    """A shape at a pose.

    Attributes:
        pose: Its pose in its link or world.
        friction: Coefficient of dry friction; None where its file names none.
        picture: Drawn upright on each side of a box, and on a mesh where its skin says; None for
            the colour alone.
    """

    shape: Shape
    pose: Pose3 = ORIGIN
    rgba: tuple[float, ...] = GREY
    friction: float | None = None
    picture: Picture | None = None

    def points(self, T: Pose3 = ORIGIN) -> Floats:
        """Return the shape's `corners` where they are, `(N, 3)` [m], in a frame that T leads to."""
        return (self.pose if T is ORIGIN else T @ self.pose).apply(corners(self.shape))


def corners(shape: Shape) -> Floats:
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
    result: Floats = CUBE * np.array(size) / 2
    return result


def points_of(parts: Iterable[Part], T: Pose3 = ORIGIN) -> Floats:
    """Return the points of several parts, `(N, 3) float64` [m]."""
    return np.vstack([np.zeros((0, 3)), *(part.points(T) for part in parts)])


def circle(radius: float) -> Floats:
    """Return points on a circle about the origin, `(64, 2) float64` [m]."""
    angles = np.arange(_ROUND) * 2.0 * math.pi / _ROUND
    ring: Floats = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return ring


@dataclass(frozen=True)
class Inertial:
    """Mass properties of a link.

    Attributes:
        mass: [kg].
        center: Centre of mass in the link's frame [m].
        inertia: About the centre, along the link's axes, `(3, 3) float64` [kg m^2].
    """

    mass: float
    center: tuple[float, float, float]
    inertia: Floats


def estimated_inertial(parts: Sequence[Part]) -> Inertial | None:
    """Return mass properties of a link that has none, by its shapes; None without shapes."""
    volume = sum(_volume(part.shape) for part in parts)
    return inertial_of_parts(parts, max(volume * DENSITY, MASS_MIN)) if volume > 0.0 else None


def volume_of(parts: Sequence[Part]) -> float:
    """Return the volume of shapes, overlaps counted twice [m^3]."""
    return sum(_volume(part.shape) for part in parts)


def inertial_of_parts(parts: Sequence[Part], mass: float) -> Inertial:
    """Return the mass properties of shapes of one density; without shapes a ball of 5 cm.

    Args:
        parts: The shapes; a mesh counts as a box around it.
    """
    volumes = np.array([_volume(part.shape) for part in parts])
    if not volumes.sum() > 0.0:
        return Inertial(mass, (0.0, 0.0, 0.0), np.eye(3) * max(0.4 * mass * 0.05**2, 1e-10))
    masses = mass * volumes / volumes.sum()
    centers = np.array([_middle(part) for part in parts])
    center = masses @ centers / mass
    inertia = np.eye(3) * 1e-10  # [kg m^2] no body has none
    for part, own, own_center in zip(parts, masses, centers, strict=True):
        rotation, arm = part.pose.rotation(), own_center - center
        inertia += rotation @ np.diag(own * _unit(part.shape)) @ rotation.T
        inertia += own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Inertial(mass, (float(center[0]), float(center[1]), float(center[2])), inertia)


def _middle(part: Part) -> Floats:
    """Return a shape's centre in its link's frame [m]."""
    low, high = _box(part.shape)
    middle: Floats = part.pose.apply(((low + high) / 2)[None])[0]
    return middle


def _box(shape: Shape) -> tuple[Floats, Floats]:
    points = corners(shape)
    return points.min(axis=0), points.max(axis=0)


def _volume(shape: Shape) -> float:
    """Return a shape's volume; of a mesh that of its hull [m^3]."""
    if shape.kind is Kind.BOX:
        return math.prod(shape.size)
    if shape.kind is Kind.CYLINDER:
        return math.pi * shape.size[0] ** 2 * shape.size[1]
    if shape.kind in (Kind.SPHERE, Kind.ELLIPSOID):
        return 4.0 / 3.0 * math.pi * math.prod((*shape.size, *shape.size[:1] * 2)[:3])
    if shape.kind is Kind.CAPSULE:
        radius, length = shape.size
        return math.pi * radius**2 * (length + 4.0 / 3.0 * radius)
    if shape.kind is Kind.MESH:
        return float(ConvexHull(corners(shape)).volume)  # never flat: see `hull`
    return 0.0


def _unit(shape: Shape) -> Floats:
    """Return a shape's principal inertias per mass about its centre [m^2]."""
    if shape.kind is Kind.CYLINDER:
        radius, length = shape.size
        across = (3.0 * radius**2 + length**2) / 12.0
        return np.array([across, across, radius**2 / 2.0])
    if shape.kind is Kind.SPHERE:
        return np.full(3, 0.4 * shape.size[0] ** 2)
    if shape.kind is Kind.ELLIPSOID:
        x, y, z = (radius**2 for radius in shape.size)
        return np.array([y + z, x + z, x + y]) / 5.0
    low, high = _box(shape)
    x, y, z = ((high - low) ** 2).tolist()
    return np.array([y + z, x + z, x + y]) / 12.0
