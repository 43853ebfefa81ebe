"""A world: its bodies, its actors, what can be pushed, and its place on Earth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.actors import Actor
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.joints import Hinge
from arjuna_sim.model.notes import Note

_EQUATOR = 6_378_137.0  # WGS 84 [m]
_FLATTENING = 1.0 / 298.257223563
_SQUARED = _FLATTENING * (2.0 - _FLATTENING)  # eccentricity^2
_ROUNDS = 6  # of Bowring's method; errs by less than a nanometre near the ground
GROUND = "ground_plane"
"""Name of the model that is the ground."""
GROUND_COLOUR = (0.6, 0.6, 0.6, 1.0)


@dataclass(frozen=True)
class Geodetic:
    """A place on WGS 84.

    Attributes:
        latitude: North of the equator [rad].
        longitude: East of Greenwich [rad].
        altitude: Above the ellipsoid [m].
    """

    latitude: float = 0.0
    longitude: float = 0.0
    altitude: float = 0.0


@dataclass(frozen=True)
class Earth:
    """Where a world's origin is on Earth.

    Attributes:
        origin: The world's origin.
        heading: From east to the world's x axis, counter-clockwise [rad].
        magnetic_field: In the world's frame [T].
    """

    origin: Geodetic = Geodetic()
    heading: float = 0.0
    magnetic_field: tuple[float, float, float] = (6e-6, 2.3e-5, -4.2e-5)

    def geodetic(self, point: NDArray[np.float64]) -> Geodetic:
        """Return the place on Earth of a point of the world, `(3,) float64` [m].

        Source: Bowring, Transformation from spatial to geographical coordinates, Survey Review 23
        (1976).
        """
        c, s = math.cos(self.heading), math.sin(self.heading)
        x, y, up = (float(value) for value in point)
        east, north = c * x - s * y, s * x + c * y
        X, Y, Z = self._ecef(east, north, up)
        level = math.hypot(X, Y)
        latitude = math.atan2(Z, level * (1.0 - _SQUARED))
        for _ in range(_ROUNDS):
            radius = _across(latitude)
            latitude = math.atan2(Z + _SQUARED * radius * math.sin(latitude), level)
        radius, slope = _across(latitude), math.sin(latitude)
        # Along the normal, which is well conditioned at the poles as well.
        altitude = level * math.cos(latitude) + Z * slope - radius * (1.0 - _SQUARED * slope**2)
        return Geodetic(latitude, math.atan2(Y, X), altitude)

    def _ecef(self, east: float, north: float, up: float) -> tuple[float, float, float]:
        """Return a point of the tangent plane in coordinates that turn with the Earth [m]."""
        origin = self.origin
        sin_lat, cos_lat = math.sin(origin.latitude), math.cos(origin.latitude)
        sin_lon, cos_lon = math.sin(origin.longitude), math.cos(origin.longitude)
        radius = _across(origin.latitude)
        outward = cos_lat * up - sin_lat * north + (radius + origin.altitude) * cos_lat
        along = sin_lat * up + cos_lat * north
        return (
            outward * cos_lon - sin_lon * east,
            outward * sin_lon + cos_lon * east,
            along + (radius * (1.0 - _SQUARED) + origin.altitude) * sin_lat,
        )


@dataclass(frozen=True)
class Body:
    """One part of a world.

    Attributes:
        model: Name of the model it belongs to.
        part: Its shape, pose in the world and colour.
        collides: Whether it stops robots and rays, or is only drawn.
        T_world_model: Where its model stands.
    """

    model: str
    part: Part
    collides: bool
    T_world_model: Pose3 = ORIGIN


@dataclass(frozen=True)
class World:
    """A world as it was read.

    Attributes:
        path: The file.
        name: The world's name.
        bodies: Its parts; the ground is one with the model `ground_plane`.
        notes: What the file says and the simulation leaves out.
        actors: What moves by itself.
        masses: By name, the models that can be pushed, and what they weigh [kg].
        hinges: By name, those of them that swing on the world.
        floating: Names of those of them that gravity leaves alone.
        earth: Where it is, for GPS and compass.
        gravity: Which way it pulls and how strongly [m/s^2].
    """

    path: Path
    name: str
    bodies: tuple[Body, ...]
    notes: tuple[Note, ...]
    actors: tuple[Actor, ...] = ()
    masses: Mapping[str, float] = field(default_factory=dict)
    hinges: Mapping[str, Hinge] = field(default_factory=dict)
    floating: frozenset[str] = frozenset()
    earth: Earth = Earth()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)

    @cached_property
    def models(self) -> dict[str, tuple[Body, ...]]:
        """The bodies by their model's name, in the file's order; found once, for all who ask."""
        found: dict[str, list[Body]] = {}
        for body in self.bodies:
            found.setdefault(body.model, []).append(body)
        return {name: tuple(bodies) for name, bodies in found.items()}

    @cached_property
    def model_names(self) -> tuple[str, ...]:
        """The names of its models, those that are ground left out, in the file's order."""
        return tuple(
            name
            for name, bodies in self.models.items()
            if not any(is_ground(name, body.part) for body in bodies)
        )


def ground() -> list[Body]:
    """Return the ground plane at height 0, solid and drawn."""
    part = Part(Shape(Kind.PLANE), rgba=GROUND_COLOUR)
    return [Body(GROUND, part, True), Body(GROUND, part, False)]


def is_ground(model: str, part: Part) -> bool:
    """Tell whether a robot stands on a part rather than runs into it."""
    return model == GROUND or part.shape.kind in (Kind.PLANE, Kind.TERRAIN)


def _across(latitude: float) -> float:
    """Return the radius of curvature across the meridian [m]."""
    return _EQUATOR / math.sqrt(1.0 - _SQUARED * math.sin(latitude) ** 2)
