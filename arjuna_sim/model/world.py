"""A world: its bodies, its actors and what can be pushed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.actors import Actor
from arjuna_sim.model.hinges import Hinge
from arjuna_sim.model.notes import Note
from arjuna_sim.model.shapes import Kind, Part, Shape

GROUND = "ground_plane"
"""Name of the model that is the ground."""
GROUND_COLOUR = (0.6, 0.6, 0.6, 1.0)


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
    """

    path: Path
    name: str
    bodies: tuple[Body, ...]
    notes: tuple[Note, ...]
    actors: tuple[Actor, ...] = ()
    masses: Mapping[str, float] = field(default_factory=dict)
    hinges: Mapping[str, Hinge] = field(default_factory=dict)
    floating: frozenset[str] = frozenset()


def ground() -> list[Body]:
    """Return the ground plane at height 0, solid and drawn."""
    part = Part(Shape(Kind.PLANE), rgba=GROUND_COLOUR)
    return [Body(GROUND, part, True), Body(GROUND, part, False)]


def is_ground(model: str, part: Part) -> bool:
    """Tell whether a robot stands on a part rather than runs into it."""
    return model == GROUND or part.shape.kind in (Kind.PLANE, Kind.TERRAIN)
