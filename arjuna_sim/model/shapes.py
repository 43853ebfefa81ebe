"""Shapes of bodies, as URDF and SDF have them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.convex_pieces import CUBE, hull

_ROUND = 64  # corners that stand for a circle
GREY = (0.7, 0.7, 0.7, 1.0)


class Kind(Enum):
    """What a shape is."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    PLANE = "plane"
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

    def hull(self, scale: tuple[float, ...]) -> NDArray[np.float64]:
        """Return the corners of its convex hull at a scale, `(N, 3) float64` [m]."""
        if scale not in self._hulls:
            self._hulls[scale] = hull(self.triangles.reshape(-1, 3) * np.array(scale))
        return self._hulls[scale]


@dataclass(frozen=True)
class Shape:
    """A shape in its own frame.

    Attributes:
        kind: What it is.
        size: Box: edges (x, y, z). Cylinder: radius, length. Sphere: radius. Plane: nothing.
            Mesh: scale (x, y, z). All [m].
        mesh: The triangles of a mesh.
    """

    kind: Kind
    size: tuple[float, ...] = ()
    mesh: Mesh | None = None


@dataclass(frozen=True)
class Part:
    """A shape at a place.

    Attributes:
        shape: The shape.
        pose: Its pose in its link or world.
        rgba: Its colour, 0..1.
    """

    shape: Shape
    pose: Pose3 = ORIGIN
    rgba: tuple[float, ...] = GREY


def corners(shape: Shape) -> NDArray[np.float64]:
    """Return points whose hull is a shape's, in its own frame, `(N, 3) float64` [m].

    Circles have 64 corners; a sphere is stood for by its bounding box, a plane by nothing.
    """
    if shape.kind is Kind.PLANE:
        return np.zeros((0, 3))
    if shape.kind is Kind.MESH:
        assert shape.mesh is not None
        return shape.mesh.hull(shape.size)
    if shape.kind is Kind.CYLINDER:
        ring = circle(shape.size[0])
        ends = [np.full((_ROUND, 1), sign * shape.size[1] / 2) for sign in (-1, 1)]
        return np.vstack([np.hstack([ring, end]) for end in ends])
    size = shape.size if shape.kind is Kind.BOX else (2 * shape.size[0],) * 3
    result: NDArray[np.float64] = CUBE * np.array(size) / 2
    return result


def circle(radius: float) -> NDArray[np.float64]:
    """Return points on a circle about the origin, `(64, 2) float64` [m]."""
    angles = np.arange(_ROUND) * 2.0 * math.pi / _ROUND
    ring: NDArray[np.float64] = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return ring
