"""Mass properties of links, and those of shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from arjuna_sim.model.geometry.shapes import Kind, Part, Shape, corners

DENSITY = 500.0
"""Of parts whose file gives no mass: half of water's, as robots are hollow [kg/m^3]."""
MASS_MIN = 1e-6
"""Least mass of a link [kg]."""
_INERTIA_MIN = 1e-10  # [kg m^2]


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
    inertia: NDArray[np.float64]


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
        mass: Of all of them [kg].
    """
    volumes = np.array([_volume(part.shape) for part in parts])
    if not volumes.sum() > 0.0:
        return Inertial(mass, (0.0, 0.0, 0.0), np.eye(3) * max(0.4 * mass * 0.05**2, _INERTIA_MIN))
    masses = mass * volumes / volumes.sum()
    places = np.array([_middle(part) for part in parts])
    center = masses @ places / mass
    inertia = np.eye(3) * _INERTIA_MIN
    for part, own, place in zip(parts, masses, places, strict=True):
        rotation, arm = part.pose.rotation(), place - center
        inertia += rotation @ np.diag(own * _unit(part.shape)) @ rotation.T
        inertia += own * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Inertial(mass, (float(center[0]), float(center[1]), float(center[2])), inertia)


def _middle(part: Part) -> NDArray[np.float64]:
    """Return a shape's centre in its link's frame [m]."""
    low, high = _box(part.shape)
    middle: NDArray[np.float64] = part.pose.apply(((low + high) / 2)[None])[0]
    return middle


def _box(shape: Shape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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


def _unit(shape: Shape) -> NDArray[np.float64]:
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
