"""Entities: the things in a world that can be named, moved, spawned and deleted."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.geometry.convex_pieces import CUBE
from arjuna_sim.model.geometry.shapes import Part, points_of
from arjuna_sim.model.urdf import Hinge, Urdf
from arjuna_sim.model.world import Actor, Trajectory, World

_PREFIX = "entity:"
POSES = re.compile(
    r"/world/[^/]+/(?P<moving>dynamic_)?pose/info|(/world/[^/]+)?/model/(?P<model>[^/]+)/pose"
)
"""gz-sim's topics of where entities are: of all, of those that move, of one with PosePublisher."""


class EntityError(ArjunaError):
    """An entity cannot be what was asked for; nothing has changed."""


class UnknownEntityError(EntityError):
    """No entity has this name."""


class BlockedPoseError(EntityError):
    """An entity would stand in the robot."""


class Category(Enum):
    """The category of an entity, in the numbers of simulation_interfaces."""

    OBJECT = 0
    ROBOT = 1
    HUMAN = 2
    DYNAMIC_OBJECT = 4
    STATIC_OBJECT = 5


def body_name(entity: str) -> str:
    """Return the name of an entity's MuJoCo body."""
    return _PREFIX + entity


@dataclass(frozen=True)
class Entity:
    """Something in a world beside the robot and the ground.

    Attributes:
        name: Its name, unique in the simulation.
        solid: The parts that stop robots and rays, in its own frame.
        drawn: The parts that are only drawn, in its own frame.
        start: Where it stands at first.
        mass: What it weighs, where it can be pushed; 0 holds it where it is put [kg].
        trajectory: How it moves by itself, if it does.
        hinge: How it swings on the world, or on another, if it does.
        on: The entity of the same model that it hangs on; "" where it is the world alone.
        mount: Its first pose in the frame of that entity.
        floats: Whether gravity leaves it alone.
        self_collides: Whether it touches others of its model.
        hung: What of its model hangs on it, each before what hangs on that: named and standing as
            seen from this one, whose name and pose those of all go by.
        spawned: Whether a client put it there, rather than the world's file.
        category: What kind of thing it is.
        description: One line on where it comes from.
        notes: What of its file is not as it says, a line each.
    """

    name: str
    solid: tuple[Part, ...]
    drawn: tuple[Part, ...] = ()
    start: Pose3 = ORIGIN
    mass: float = 0.0
    trajectory: Trajectory | None = None
    hinge: Hinge | None = None
    on: str = ""
    mount: Pose3 = ORIGIN
    floats: bool = False
    self_collides: bool = False
    hung: tuple[Entity, ...] = ()
    spawned: bool = False
    category: Category = Category.STATIC_OBJECT
    description: str = ""
    notes: tuple[str, ...] = ()

    @property
    def body(self) -> str:
        """Name of its MuJoCo body."""
        return body_name(self.name)

    def whole(self) -> dict[str, Entity]:
        """Return this and what hangs on it as they stand in the world, by name."""
        found = {self.name: self}
        for part in self.hung:
            name, on = self.name + part.name, self.name + part.on
            start = self.start @ part.start
            mount = found[on].start.inverse() @ start
            found[name] = dataclasses.replace(part, name=name, on=on, start=start, mount=mount)
        return found

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the least and the greatest corner of what is solid, in its own frame [m]."""
        return bounds(self.solid or self.drawn)

    def lifted(self, pose: Pose3) -> Pose3:
        """Return a pose so high that, where it can be pushed, nothing of it is below height 0.

        It would be thrown out of the ground there.
        """
        placed = dataclasses.replace(self, start=pose).whole().values()
        lowest = min(float(one.corners(one.start)[:, 2].min()) for one in placed)
        if self.mass == 0.0 or lowest >= 0.0:
            return pose
        x, y, z = pose.position
        return Pose3((x, y, z - lowest), pose.quaternion)

    def corners(self, pose: Pose3) -> Floats:
        """Return the corners of its bounding box where it stands, `(8, 3) float64` [m]."""
        low, high = self.bounds()
        return pose.apply((low + high) / 2 + CUBE * (high - low) / 2)


@dataclass(frozen=True)
class EntityMotion:
    """The pose and motion of an entity in the world.

    Attributes:
        linear: Velocity of its origin [m/s].
        angular: Turn rates [rad/s].
    """

    pose: Pose3
    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)


def bounds(parts: Iterable[Part]) -> tuple[Floats, Floats]:
    """Return the least and the greatest corner of parts, `(3,) float64` each [m]."""
    found = points_of(parts)
    if not len(found):
        return np.zeros(3), np.zeros(3)
    return found.min(axis=0), found.max(axis=0)


def entity_of_model(world: World, name: str) -> Entity:
    """Return a model of a world as an entity that stands where the world has it."""
    bodies = world.models[name]
    T_world_model = bodies[0].T_world_model
    T_model_world = T_world_model.inverse()
    parts: dict[bool, list[Part]] = {True: [], False: []}
    for body in bodies:
        pose = T_model_world @ body.part.pose
        parts[body.collides].append(dataclasses.replace(body.part, pose=pose))
    about = f"a model of the world '{world.name}'"
    return Entity(name, tuple(parts[True]), tuple(parts[False]), T_world_model, description=about)


def entity_of_actor(actor: Actor) -> Entity:
    """Return an actor as an entity that follows its waypoints."""
    return Entity(
        actor.name,
        actor.parts,
        start=Pose3.from_se2(actor.start),
        trajectory=actor.trajectory,
        category=Category.HUMAN,
        description="an actor",
    )


def moving_entities(world: World) -> dict[str, Entity]:
    """Return what a world holds that can move, by name: its actors, and models to be pushed."""
    moving = {actor.name: entity_of_actor(actor) for actor in world.actors}
    for name, movable in world.movable.items():
        model = entity_of_model(world, name)
        category = Category.DYNAMIC_OBJECT
        part = dataclasses.replace(model, category=category, **movable._asdict())
        if part.on:
            carrier = world.models[part.on][0].T_world_model
            part = dataclasses.replace(part, mount=carrier.inverse() @ part.start)
        moving[name] = part
    return moving


def entity_of_robot(urdf: Urdf) -> Entity:
    """Return a robot, all its joints at 0, as one rigid entity."""
    solid, drawn = [], []
    for name, link in urdf.links.items():
        T_root = urdf.T_root(name)
        solid += [Part(p.shape, T_root @ p.pose, p.rgba) for p in link.collisions]
        drawn += [dataclasses.replace(p, pose=T_root @ p.pose) for p in link.visuals]
    about = f"the robot of {urdf.path.name}"
    return Entity(
        urdf.name,
        tuple(solid),
        tuple(drawn),
        mass=urdf.mass,
        category=Category.ROBOT,
        description=about,
    )
