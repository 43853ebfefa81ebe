"""A world: its bodies, its actors, and its position on Earth."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ConfigError
from arjuna_core.geodesy import GRAVITY, GeoPoint, MapOnEarth
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.joints import Gains
from arjuna_sim.model.look import Look
from arjuna_sim.model.notes import Note
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Hinge

PERSON = (0.25, 1.7)
"""Radius and height of the cylinder that stands for a person [m]."""
_NULL_ISLAND = GeoPoint(0.0, 0.0)
GROUND = "ground_plane"
"""Name of the model that is the ground."""
GROUND_COLOUR = (0.6, 0.6, 0.6, 1.0)


@dataclass(frozen=True)
class Trajectory:
    """Poses at times, and straight lines between them.

    Attributes:
        times: When each waypoint is reached, from the start, never falling [s].
        poses: The waypoints in the world.
        loop: Whether it starts again at its end.
        delay: Time to stand at the first waypoint before each round [s].
    """

    times: tuple[float, ...]
    poses: tuple[SE2, ...]
    loop: bool = True
    delay: float = 0.0

    @staticmethod
    def along(points: Floats, speed: float, loop: bool = True) -> Trajectory:
        """Build a trajectory that follows points at a constant speed, facing ahead.

        Args:
            points: Where to go `(N, 2) float64` [m]; a loop goes back to the first.
            loop: Whether it starts again at its end.

        Raises:
            ConfigError: There are fewer than two points, or a value is no path or speed.
        """
        if len(points) < 2 or not np.isfinite(points).all():
            raise ConfigError(f"a path needs two or more finite points, got {len(points)}")
        if not 0.0 < speed < math.inf:
            raise ConfigError(f"speed is {speed} m/s; valid: above 0")
        path = np.vstack((points, points[:1])) if loop else points
        times, poses, now = [], [], 0.0
        for (x0, y0), (x1, y1) in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
            heading = math.atan2(y1 - y0, x1 - x0)
            end = now + math.hypot(x1 - x0, y1 - y0) / speed
            times += [now, end]
            poses += [SE2(x0, y0, heading), SE2(x1, y1, heading)]
            now = end
        return Trajectory(tuple(times), tuple(poses), loop)

    def pose(self, elapsed: float) -> SE2:
        """Return the pose at a time from the start [s]."""
        whole = self.delay + self.times[-1]
        if self.loop and whole > 0.0:
            elapsed = math.fmod(elapsed, whole)
        t = elapsed - self.delay
        i = bisect_right(self.times, t)
        if i == 0 or i == len(self.times):
            return self.poses[min(i, len(self.times) - 1)]
        a, b = self.poses[i - 1], self.poses[i]
        ratio = (t - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        return SE2(
            a.x + ratio * (b.x - a.x),
            a.y + ratio * (b.y - a.y),
            wrap(a.theta + ratio * wrap(b.theta - a.theta)),
        )

    def velocity(self, elapsed: float) -> tuple[float, float, float]:
        """Return `(vx, vy, w)` in the world at a time from the start [m/s, m/s, rad/s]."""
        step = 1e-3  # over which the velocity is measured [s]
        a, b = self.pose(elapsed), self.pose(elapsed + step)
        turn = wrap(b.theta - a.theta)
        return (b.x - a.x) / step, (b.y - a.y) / step, turn / step


@dataclass(frozen=True)
class Actor:
    """One actor of a world file.

    Attributes:
        parts: What it is made of, in its own frame, which stands on the ground.
        start: Where it is before it moves.
        trajectory: How it moves; None for one that stands.
    """

    name: str
    parts: tuple[Part, ...]
    start: SE2
    trajectory: Trajectory | None


def person() -> tuple[Part, ...]:
    """Return the shape that stands for a person: an upright cylinder."""
    height = PERSON[1]
    middle = Pose3((0.0, 0.0, height / 2))
    # Friction of clothes on plastic, 0.2 to 0.4: legs slide along a robot and do not lift it.
    return (Part(Shape(Kind.CYLINDER, PERSON), middle, (0.3, 0.4, 0.8, 1.0), 0.3),)


@dataclass(frozen=True)
class Earth:
    """The position of a world's origin on Earth.

    Attributes:
        heading: From east to the world's x axis, counter-clockwise [rad].
        magnetic_field: In the world's frame [T].
    """

    origin: GeoPoint = _NULL_ISLAND
    heading: float = 0.0
    magnetic_field: tuple[float, float, float] = (6e-6, 2.3e-5, -4.2e-5)

    def geodetic(self, point: Floats) -> GeoPoint:
        """Return the position on Earth of a point of the world, `(3,) float64` [m]."""
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
class Fixture:
    """A sensor of a world's model.

    Attributes:
        settings: The sensor; its link and its name are those of its site.
        model: The model it is fixed to.
        T_world: Its first pose in the world.
        T_model: Its pose in the model.
    """

    settings: SensorSettings
    model: str
    T_world: Pose3
    T_model: Pose3


class Movable(NamedTuple):
    """A model, or a part of one, that can be pushed.

    Attributes:
        mass: What it weighs [kg].
        hinge: How it swings, if it does.
        floats: Whether gravity leaves it alone.
        on: The part or model that it hangs on by its hinge; "" for the world.
        self_collides: Whether it touches other parts of its model.
    """

    mass: float
    hinge: Hinge | None
    floats: bool
    on: str = ""
    self_collides: bool = False


class Mover(NamedTuple):
    """A command of a model that moves by itself: at the start, and the topic of others."""

    velocity: Velocity
    topic: str


class Motor(NamedTuple):
    """What turns a part of a model by its hinge.

    Attributes:
        topic: Of its commands.
        command: What they are: a position, a velocity or an effort.
        start: The command at the start [rad or m, rad/s or m/s, N m or N].
        gains: Of a position, where the file gives them; else they are derived from what it moves.
        most: Its greatest effort, 0 for one by what it moves [N m or N].
        belt: Of a belt the least and the greatest speed; None for what is no belt [m/s].
    """

    topic: str
    command: str
    start: float = 0.0
    gains: Gains | None = None
    most: float = 0.0
    belt: tuple[float, float] | None = None


class Follower(NamedTuple):
    """What pushes a model from waypoint to waypoint, by forces.

    Attributes:
        waypoints: In the world [m].
        loop: Whether it begins again behind the last.
        force: Along its x axis, while it is headed for the next [N].
        torque: About its z axis, while it is not [N m].
        reach: How near it comes to a waypoint [m].
        aim: How far off a waypoint's bearing it is headed for it [rad].
        holds: Whether it stops turning once it is headed for it.
    """

    waypoints: tuple[tuple[float, float], ...]
    loop: bool = False
    force: float = 60.0
    torque: float = 50.0
    reach: float = 0.5
    aim: float = math.radians(2.0)
    holds: bool = False


@dataclass(frozen=True)
class World:
    """A world as it was read.

    Attributes:
        bodies: Its parts; the ground is one with the model `ground_plane`.
        notes: What the file says and the simulation leaves out.
        actors: What moves by itself.
        movable: By name, the models that can be pushed.
        movers: By name, those of them that move by themselves.
        followers: By name, those of them that are pushed along waypoints.
        motors: By name, what turns those of them that swing.
        earth: Where it is, for GPS and compass.
        gravity: Acceleration of free fall, in the world's frame [m/s^2].
        look: Its lights, sky and fog.
        sensors: The sensors of its models.
    """

    path: Path
    name: str
    bodies: tuple[Body, ...]
    notes: tuple[Note, ...]
    actors: tuple[Actor, ...] = ()
    movable: Mapping[str, Movable] = field(default_factory=dict)
    earth: Earth = Earth()
    gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)
    look: Look = field(default_factory=Look)
    sensors: tuple[Fixture, ...] = ()
    movers: Mapping[str, Mover] = field(default_factory=dict)
    followers: Mapping[str, Follower] = field(default_factory=dict)
    motors: Mapping[str, Motor] = field(default_factory=dict)

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


def ground_bodies() -> list[Body]:
    """Return the ground plane at height 0, solid and drawn."""
    part = Part(Shape(Kind.PLANE), rgba=GROUND_COLOUR)
    return [Body(GROUND, part, True), Body(GROUND, part, False)]


def is_ground(model: str, part: Part) -> bool:
    """Return whether a robot stands on a part rather than runs into it."""
    return model == GROUND or part.shape.kind in (Kind.PLANE, Kind.TERRAIN)
