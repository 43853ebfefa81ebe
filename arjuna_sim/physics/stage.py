"""The stage: robots, world and entities as one MuJoCo model, which may change over time."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError, nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import (
    BlockedPoseError,
    Category,
    Entity,
    EntityError,
    EntityMotion,
    UnknownEntityError,
    entity_of_model,
    moving_entities,
)
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.world import World
from arjuna_sim.physics.contacts import touched
from arjuna_sim.physics.entity_body import addresses_of, motion_of
from arjuna_sim.physics.forces import Forces
from arjuna_sim.physics.ground import Ground
from arjuna_sim.physics.movers import Movers
from arjuna_sim.physics.running import Stepper, carry_over
from arjuna_sim.physics.scene import Scene, build_scene
from arjuna_sim.physics.walkers import Manners, Walkers
from arjuna_sim.physics.wheels.servo import ServoConfig


class Stage:
    """Holds the model and its state, and keeps the state when the model changes.

    A world's models are part of the static world until someone moves or deletes one: the model is
    then compiled again, as for a spawn, and every joint keeps its state.

    Args:
        robots: The robots by name; links, joints and sensors of no two have the same name.
        timestep: Of the physics [s].

    Attributes:
        scene: The compiled model and where to find things in it.
        on_rebuild: Called when `scene` and `data` were replaced.
        movers: Those of its world's models that move by themselves, and their motors.
        forces: What clients push it with.

    Raises:
        RobotError: MuJoCo refuses a robot or the world.
    """

    def __init__(
        self, robots: Mapping[str, RobotModel], world: World, servo: ServoConfig, timestep: float
    ) -> None:
        self.robots = dict(robots)
        self._servo = servo
        self._timestep = timestep
        self.on_rebuild: Callable[[], None] = lambda: None
        self.forces = Forces()
        self._set_up(world)

    def _set_up(self, world: World) -> None:
        entities, taken = moving_entities(world), frozenset(world.movable)
        self.movers = Movers(world.movers, world.followers, world.motors)
        self.forces.clear()
        compiled = self._compile(world, entities, taken, keep=True)
        self._install(world, entities, taken, *compiled)
        self._stand_people_up()
        self._steps = 0
        self._began: Counter[str] = Counter()

    @property
    def elapsed(self) -> float:
        """The time that the physics has run since the last restart [s]."""
        return self._steps * self._timestep

    def load(self, world: World) -> None:
        """Replace the world and all entities; the robots are at the origin.

        Raises:
            RobotError: MuJoCo refuses the world; nothing has changed.
        """
        self._set_up(world)
        self.on_rebuild()

    @property
    def entities(self) -> tuple[Entity, ...]:
        """All entities: those of the world first, then those that were spawned."""
        models = [n for n in self.world.model_names if n not in self._taken]
        fixed = [entity_of_model(self.world, name) for name in models]
        return (*fixed, *self._entities.values())

    def entity(self, name: str) -> Entity:
        """Return the entity of a name.

        Raises:
            UnknownEntityError: There is none; the message names the nearest.
        """
        if name in self._entities:
            return self._entities[name]
        models = [n for n in self.world.model_names if n not in self._taken]
        if name in models:
            return entity_of_model(self.world, name)
        raise UnknownEntityError(
            f"entity '{name}' does not exist; {nearest(name, [*models, *self._entities])}"
        )

    def spawn(self, entity: Entity, walked: float = 0.0) -> None:
        """Put an entity of a new name into the world.

        Args:
            walked: How long ago its trajectory began [s].

        Raises:
            BlockedPoseError: It would stand in a robot; nothing has changed.
            RobotError: MuJoCo refuses it; nothing has changed.
        """
        if entity.trajectory is not None:
            start = Pose3.from_se2(entity.trajectory.pose(walked))
            entity = dataclasses.replace(entity, start=start)
        self._change({**self._entities, **entity.whole()}, self._taken, entity)
        self._began[entity.name] = self._steps - round(walked / self._timestep)

    def delete(self, name: str) -> None:
        """Take an entity out of the world, and what hangs on it.

        Raises:
            UnknownEntityError: There is none of this name.
        """
        self.entity(name)
        lost = {name}
        for key, entity in self._entities.items():  # each before what hangs on it
            lost |= {key} if entity.on in lost else set()
        kept = {key: entity for key, entity in self._entities.items() if key not in lost}
        gone = frozenset() if name in self._entities else frozenset((name,))
        self._change(kept, self._taken | gone)

    def move(self, name: str, pose: Pose3) -> None:
        """Put an entity somewhere else, at rest.

        Raises:
            UnknownEntityError: There is none of this name.
            EntityError: It hangs on another that moves.
            BlockedPoseError: It would stand in a robot; nothing has changed.
        """
        entity = self.entity(name)
        if entity.on in self._entities and self._entities[entity.on].mass > 0.0:
            raise EntityError(f"'{name}' hangs on '{entity.on}': that can be moved")
        if entity.hinge is not None:  # its hinge goes with it
            moved = dataclasses.replace(entity, start=pose)
            self._change({**self._entities, name: moved}, self._taken, moved)
            return
        if name not in self._entities:  # a model of the static world, before what hangs on it
            entities, taken = {name: entity, **self._entities}, self._taken | {name}
            self._change(entities, taken)
        before = self.motion(name).pose
        self._put(entity, pose)
        robot = self._touched_robot(entity)
        if robot is not None:
            self._put(entity, before)
            self.settle()
            raise _stands_in(entity, robot)
        self.settle()

    def push(self, name: str, velocity: Floats) -> None:
        """Set an entity's velocity and turn rates in the world, `(6,) float64` [m/s, rad/s].

        Raises:
            UnknownEntityError: There is none of this name.
            EntityError: It does not move freely.
        """
        entity = self.entity(name)
        if entity.mass == 0.0 or entity.hinge is not None:
            raise EntityError(f"'{name}' does not move freely: it has no velocity to set")
        turn, rate = self.motion(name).pose.rotation().T, self._handles[name][2]
        self.data.qvel[rate : rate + 6] = np.concatenate((velocity[:3], turn @ velocity[3:]))
        self.settle()

    def motion(self, name: str) -> EntityMotion:
        """Return where an entity is and how it moves.

        Raises:
            UnknownEntityError: There is none of this name.
        """
        entity = self.entity(name)
        if name not in self._entities:
            return EntityMotion(entity.start)
        found = motion_of(self.scene.model, self.data, entity)
        if entity.trajectory is None:
            return found
        vx, vy, w = entity.trajectory.velocity(self.walking_time(name))
        return EntityMotion(found.pose, (vx, vy, 0.0), (0.0, 0.0, w))

    def clear_spawned(self) -> None:
        """Take out all that was spawned."""
        kept = {name: entity for name, entity in self._entities.items() if not entity.spawned}
        if len(kept) < len(self._entities):
            self._change(kept, self._taken)

    def restore(self) -> None:
        """Return to the world as it was read, with everything at its start."""
        moving = list(moving_entities(self.world))
        if self._taken != frozenset(self.world.movable) or list(self._entities) != moving:
            self._set_up(self.world)
            self.on_rebuild()
        self._steps = 0
        self.forces.clear()
        self.movers.rewind()
        self.rewind()

    def rewind(self) -> None:
        """Put everything that is there to its start, at rest."""
        mujoco.mj_resetData(self.scene.model, self.data)
        self._stand_people_up()
        self._began = Counter(dict.fromkeys(self._entities, self._steps))
        self._follow()

    def advance(self, steps: int) -> None:
        """Run the physics for a number of steps."""
        if self.scene.turned:
            self.movers.motors.drive(self.scene, self.data, steps * self._timestep)
        if self._runs_alone and not self.movers and not self.forces:
            self._steps += steps
            self._stepper.run(steps)
            return
        for _ in range(steps):
            self._steps += 1
            self._follow()
            self.movers.push(self.scene.model, self.data, self._handles)
            if self.forces:
                self.forces.apply(self.elapsed)
            self._stepper.run(1)
            self.data.qpos[self.scene.rollers] = 0.0

    def walking_time(self, name: str) -> float:
        """Return how far an entity is on its trajectory [s]."""
        return (self._steps - self._began[name]) * self._timestep

    def _follow(self) -> None:
        if len(self._walkers):
            self._began.update(self._walking[k] for k in self._manners.stopped(self.data))
            self._walkers.put(self.data, np.array([self.walking_time(n) for n in self._walking]))

    def contacts(self, robot: str) -> tuple[str, ...]:
        """Return the names of what a robot touches, sorted; never what it stands on."""
        return touched(self.scene, self.data, robot)

    def set_robots(self, robots: Mapping[str, RobotModel]) -> None:
        """Replace the robots: those that stay keep their state, new ones are at the origin.

        Raises:
            RobotError: MuJoCo refuses one; nothing has changed.
        """
        before, self.robots = self.robots, dict(robots)
        try:
            self._change(self._entities, self._taken)
        except ArjunaError:
            self.robots = before
            raise

    def _compile(
        self,
        world: World,
        entities: dict[str, Entity],
        taken: frozenset[str],
        keep: bool = False,
    ) -> tuple[Scene, Any]:
        bodies = tuple(body for body in world.bodies if body.model not in taken)
        rest = dataclasses.replace(world, bodies=bodies)
        moving = tuple(entities.values())
        scene = build_scene(self.robots, rest, self._servo, self._timestep, moving, keep)
        return scene, mujoco.MjData(scene.model)

    def _change(
        self, entities: dict[str, Entity], taken: frozenset[str], new: Entity | None = None
    ) -> None:
        """Compile again and carry the state over; refuse what is new where a robot is."""
        scene, data = self._compile(self.world, entities, taken)
        carry_over(self.scene.model, self.data, scene.model, data)
        before = (self.world, self._entities, self._taken, self.scene, self.data)
        self._install(self.world, entities, taken, scene, data)
        robot = None if new is None else self._touched_robot(new)
        if new is not None and robot is not None:
            self._install(*before)
            raise _stands_in(new, robot)
        self.settle()
        self.on_rebuild()

    def _install(
        self,
        world: World,
        entities: dict[str, Entity],
        taken: frozenset[str],
        scene: Scene,
        data: Any,
    ) -> None:
        self.world, self._entities, self._taken = world, entities, taken
        self.scene, self.data = scene, data
        self.forces.bind(scene.model, data)
        self._stepper = Stepper(scene.model, data)
        self._handles = {name: addresses_of(scene.model, one) for name, one in entities.items()}
        self.movers.smooth(scene.model, self._handles)
        walking = {n: e.trajectory for n, e in entities.items() if e.trajectory is not None}
        self._walking = tuple(walking)
        bodies = [self._handles[name][0] for name in walking]
        ground = Ground(scene.model, data, fixed=True)
        self._walkers = Walkers(bodies, list(walking.values()), ground)
        self._manners = Manners(scene.model, bodies, self._timestep)
        self._runs_alone = not walking and not len(scene.rollers)

    def _put(self, entity: Entity, pose: Pose3) -> None:
        mocap, at, rate = self._handles[entity.name]
        if mocap >= 0:
            self.data.mocap_pos[mocap] = pose.position
            self.data.mocap_quat[mocap] = pose.quaternion
        else:
            self.data.qpos[at : at + 7] = (*pose.position, *pose.quaternion)
            self.data.qvel[rate : rate + 6] = 0.0
            self.data.qacc_warmstart[rate : rate + 6] = 0.0

    def _stand_people_up(self) -> None:
        """Put the world's people who stand on its ground, as its file gives them no height."""
        people = [e for e in self._entities.values() if e.category is Category.HUMAN]
        standing = [e for e in people if not e.spawned and e.trajectory is None]
        for person in standing:
            ground = Ground(self.scene.model, self.data, fixed=True)
            x, y, _ = person.start.position
            self._put(person, Pose3((x, y, ground.stood_on(x, y)), person.start.quaternion))

    def _touched_robot(self, entity: Entity) -> str | None:
        mujoco.mj_fwdPosition(self.scene.model, self.data)
        own = entity.whole().keys()
        return next((r for r in self.robots if not own.isdisjoint(self.contacts(r))), None)

    def settle(self) -> None:
        """Bring positions and velocities up to the state."""
        model, data = self.scene.model, self.data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)


def _stands_in(entity: Entity, robot: str) -> BlockedPoseError:
    whom = f"robot '{robot}'" if robot else "the robot"
    return BlockedPoseError(f"'{entity.name}' would stand in {whom} there")
