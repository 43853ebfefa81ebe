"""A world: its bodies, its actors, what can be pushed, and its place on Earth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.geodesy import GeoPoint, MapOnEarth
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.actors import Actor
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.joints import Hinge
from arjuna_sim.model.notes import Note

_NULL_ISLAND = GeoPoint(0.0, 0.0)
GROUND = "ground_plane"
"""Name of the model that is the ground."""
GROUND_COLOUR = (0.6, 0.6, 0.6, 1.0)


@dataclass(frozen=True)
class Earth:
    """Where a world's origin is on Earth.

    Attributes:
        origin: The world's origin.
        heading: From east to the world's x axis, counter-clockwise [rad].
        magnetic_field: In the world's frame [T].
    """

    origin: GeoPoint = _NULL_ISLAND
    heading: float = 0.0
    magnetic_field: tuple[float, float, float] = (6e-6, 2.3e-5, -4.2e-5)

    def geodetic(self, point: NDArray[np.float64]) -> GeoPoint:
        """Return the place on Earth of a point of the world, `(3,) float64` [m]."""
        return self._map.to_earth(*(float(value) for value in point))

    @cached_property
    def _map(self) -> MapOnEarth:
        return MapOnEarth(self.origin, heading=self.heading)


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
