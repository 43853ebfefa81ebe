"""Robots and world compiled into one MuJoCo model, and where to find things in it."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from arjuna_core import pose3
from arjuna_core.arrays import Bools, Ints
from arjuna_core.errors import RobotError, WorldError
from arjuna_core.files.array_cache import Arrays, cached, content_of, made_by
from arjuna_sim.devices.camera import add_camera
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.entities import Entity, body_name
from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.world import World
from arjuna_sim.physics.entity_body import add_entity, add_fixture, let_pass
from arjuna_sim.physics.geoms import add_world, rank_friction
from arjuna_sim.physics.joint_servos import (
    JointServos,
    Motored,
    add_joint_servos,
    motored,
    tune_joint_servos,
)
from arjuna_sim.physics.lights import set_reach
from arjuna_sim.physics.robot_body import FAST, add_mounts, add_robot, free_joint, let_meet
from arjuna_sim.physics.running import let_sleep, loaded, saved
from arjuna_sim.physics.wheels.servo import ServoConfig, Servos, roller_addresses, tune_servos
from arjuna_sim.physics.wheels.tyres import STICTION, WheelSupport, sag_of, tune_tyres

_SLOW = 10_000  # faces of a world that take a second to compile
_ARENA = (64_000_000, 1_000_000_000)  # least and most memory for contacts [bytes]


@dataclass(frozen=True)
class RobotInScene:
    """Addresses of a robot in a compiled model.

    Attributes:
        title: What others call it: its name, or its file's where it is `SOLO`.
        base: Address of its root in qpos (7 values) and qvel (6 values).
        rates: Which values of qvel are its own.
        joint_position: Addresses of the moving joints in qpos, in the robot's order.
        joint_velocity: Addresses of the moving joints in qvel, in the robot's order.
        rollers: Addresses in qpos of what the rollers of wheels have turned.
        is_solid: For each geom whether it is a collision shape of the robot, `(G,) bool`.
        support: What it stands on.
        servos: The wheels' motors.
        joint_servos: The motors of the other driven joints.
    """

    title: str
    base: tuple[int, int]
    rates: slice
    joint_position: Ints
    joint_velocity: Ints
    rollers: Ints
    is_solid: Bools
    support: WheelSupport
    servos: Servos
    joint_servos: JointServos


@dataclass(frozen=True)
class Scene:
    """A compiled model.

    Attributes:
        robots: Its robots by name.
        names: For each geom the model, or the one of several robots, that it belongs to; "" for the
            ground.
        is_obstacle: For each geom whether it has such a name, `(G,) bool`.
        rollers: Addresses in qpos of what the rollers of all wheels have turned.
        motors: The servos of the world's motors.
        turned: The entities that those turn, in their order.
    """

    model: Any
    robots: dict[str, RobotInScene]
    names: tuple[str, ...]
    is_obstacle: Bools
    rollers: Ints
    motors: JointServos
    turned: tuple[str, ...]


def build_scene(
    robots: Mapping[str, RobotModel],
    world: World,
    servo: ServoConfig,
    timestep: float,
    entities: tuple[Entity, ...] = (),
    keep: bool = False,
) -> Scene:
    """Compile robots in a world, each at the origin.

    Args:
        robots: The robots by name; links, joints and sensors of no two have the same name.
        timestep: Of the physics [s].
        entities: What moves by itself, was moved or was spawned.
        keep: Whether a model that takes long is read from the user's cache, and kept there.

    Raises:
        RobotError: MuJoCo refuses a robot, with its reason, or there are too many.
        WorldError: It refuses the world.
    """
    made_of = robots, world, servo, timestep, entities
    make = _kept if keep and _faces(world) >= _SLOW else _made
    model, models, owners = make(*made_of)
    _set_scale(model)
    set_reach(model, world.look)
    turned = _turned(world, entities)
    driven = (each for each in entities if each.hinge and each.name in world.motors)
    hinged = [int(model.joint(each.body).bodyid[0]) for each in driven]
    let_sleep(model, [*(_root(model, robot) for robot in robots.values()), *hinged])
    motors = tune_joint_servos(model, list(turned.values()), servo), tuple(turned)
    return _scene(model, _tuned(model, robots, servo, timestep), models, owners, motors)


def _turned(world: World, entities: tuple[Entity, ...]) -> dict[str, Motored]:
    """Return by name what a world's motors turn."""
    return {
        each.name: Motored(each.body, motor.gains, motor.most)
        for each in entities
        if each.hinge and not each.hinge.runs and (motor := world.motors.get(each.name))
    }


def _faces(world: World) -> int:
    """Return how many faces the meshes of a world have, each as often as it stands there."""
    meshes = (body.part.shape.mesh for body in world.bodies if body.collides)
    return sum(len(mesh.triangles) for mesh in meshes if mesh is not None)


def _kept(*made_of: Any) -> tuple[Any, list[str], list[str]]:
    """Return what `_made` returns, from the user's cache where that was made before."""
    built: list[Any] = []

    def make() -> Arrays:
        model, *names = _made(*made_of)
        built.append(model)
        return saved(model), *map(np.array, names)

    code = sorted(str(path) for path in Path(__file__).parents[1].rglob("*.py"))
    by = made_by(pose3.__file__, *code), f"{mujoco.__version__} {platform.machine()}".encode()
    content, models, owners = cached("models", (*by, content_of(made_of)), make)
    return built[0] if built else loaded(content), models.tolist(), owners.tolist()


def _made(
    robots: Mapping[str, RobotModel],
    world: World,
    servo: ServoConfig,
    timestep: float,
    entities: tuple[Entity, ...],
) -> tuple[Any, list[str], list[str]]:
    """Return a compiled model, and what its geoms of the world and of the entities are of."""
    spec = mujoco.MjSpec()
    _set_physics(spec, timestep)
    spec.option.gravity = world.gravity
    hold = {entity.on for entity in entities} & {body.model for body in world.bodies}
    models = add_world(spec, world, {name: body_name(name) for name in sorted(hold)})
    for robot in robots.values():
        add_robot(spec, robot, servo, sag_of(robot, timestep))
        add_mounts(spec, robot)
        for sensor in robot.settings.sensors:
            if isinstance(sensor, CameraSettings):
                add_camera(spec, sensor)
    let_meet(spec, tuple(robots.values()))
    owners = [entity.name for entity in entities for _ in range(add_entity(spec, entity))]
    let_pass(spec, entities)
    add_joint_servos(spec, list(_turned(world, entities).values()))
    for fixture in world.sensors:
        add_fixture(spec, fixture, [entity.name for entity in entities])
        if isinstance(fixture.settings, CameraSettings):
            add_camera(spec, fixture.settings)
    moving = {entity.name for entity in entities if entity.mass > 0.0}
    spec.memory = _memory(sum(owner in moving for owner in owners))
    return _compiled(spec, robots, world), models, owners


def _set_scale(model: Any) -> None:
    """Let the solver's tolerance go by what moves: a robot held fast has an inertia beyond all.

    The solver would take the world for solved while an arm on such a robot has not moved yet.
    """
    moving = model.dof_armature < FAST
    if not moving.all() and moving.any():
        model.opt.tolerance *= model.dof_M0[moving].mean() / model.dof_M0.mean()


def _compiled(spec: Any, robots: Mapping[str, RobotModel], world: World) -> Any:
    try:
        return spec.compile()
    except ValueError as error:
        reason = f"cannot be simulated: {' '.join(str(error).split())}"
        if robots and _is_sound(world):
            raise RobotError(list(robots.values())[-1].urdf.path, reason) from error
        raise WorldError(world.path, reason) from error


def _tuned(
    model: Any, robots: Mapping[str, RobotModel], servo: ServoConfig, timestep: float
) -> dict[str, RobotInScene]:
    support = {
        name: tune_tyres(model, robot, sag_of(robot, timestep)) for name, robot in robots.items()
    }
    rank_friction(model, sorted(tyre for each in support.values() for tyre in each.tyres))
    return {
        name: _found(model, name, robot, servo, support[name]) for name, robot in robots.items()
    }


def _memory(geoms: int) -> int:
    """Return the memory for contacts of so many shapes that can be pushed [bytes].

    Where it is short MuJoCo forgets contacts, and what stood on them falls. A shape meets the
    ground in up to four points, of three forces each; solving takes the square of all of them.
    Only what is used is taken from the machine.
    """
    return int(min(_ARENA[0] + 4 * 8 * (4 * 3 * geoms) ** 2, _ARENA[1]))


def _is_sound(world: World) -> bool:
    spec = mujoco.MjSpec()
    add_world(spec, world)
    try:
        spec.compile()
    except ValueError:
        return False
    return True


def _set_physics(spec: Any, timestep: float) -> None:
    """Choose the solver.

    An elliptic cone makes friction the same in all directions; the discrete integrator solves
    contacts and the servos' damping as one, so that neither fights the other.
    """
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = STICTION
    # MuJoCo's default, 1e-8, takes more iterations a step.
    spec.option.tolerance = 1e-6
    # What lies still costs little then, and what stands fast is placed once and not at each step,
    # which takes 8 times as long in a world of 26 000 pieces.
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    spec.compiler.balanceinertia = True
    spec.compiler.degree = False


def _root(model: Any, robot: RobotModel) -> int:
    return int(model.body(f"body:{robot.urdf.root}").id)


def _found(
    model: Any, name: str, robot: RobotModel, servo: ServoConfig, support: WheelSupport
) -> RobotInScene:

    def positions(names: tuple[str, ...]) -> Ints:
        return np.array([model.joint(name).qposadr[0] for name in names], np.int64)

    moving, root = robot.moving_joints, _root(model, robot)
    base = model.joint(free_joint(robot))
    rates = np.flatnonzero(model.body_rootid[model.dof_bodyid] == root)
    is_own = model.body_rootid[model.geom_bodyid] == root
    return RobotInScene(
        name or robot.urdf.name,
        (int(base.qposadr[0]), int(base.dofadr[0])),
        slice(int(rates[0]), int(rates[-1]) + 1),
        positions(moving),
        np.array([model.joint(name).dofadr[0] for name in moving], np.int64),
        roller_addresses(model, robot),
        is_own & (model.geom_group == Group.ROBOT_COLLISION.value),
        support,
        tune_servos(model, robot, servo),
        tune_joint_servos(model, motored(robot), servo),
    )


def _scene(
    model: Any,
    robots: dict[str, RobotInScene],
    models: list[str],
    owners: list[str],
    motors: tuple[JointServos, tuple[str, ...]],
) -> Scene:
    """Name geoms; they are in the order of their bodies: the world, the robots, the entities."""
    names = [*models, *[""] * (model.ngeom - len(models) - len(owners)), *owners]
    for robot in robots.values() if len(robots) > 1 else ():
        for geom in np.flatnonzero(robot.is_solid).tolist():
            names[geom] = robot.title
    rollers = [robot.rollers for robot in robots.values()]
    return Scene(
        model,
        robots,
        tuple(names),
        np.array([name != "" for name in names]),
        np.concatenate([np.zeros(0, np.int64), *rollers]),
        *motors,
    )
