"""Robot and world compiled into one MuJoCo model, and where to find things in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import RobotError, WorldError
from arjuna_sim.devices.camera import add_camera
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.robot import Robot
from arjuna_sim.model.settings import CameraSettings
from arjuna_sim.model.world import World
from arjuna_sim.physics.entity_body import add_entity
from arjuna_sim.physics.robot_body import BODY_JOINT, add_mounts, add_robot
from arjuna_sim.physics.sleeping import let_sleep
from arjuna_sim.physics.wheels.rollers import roller_addresses
from arjuna_sim.physics.wheels.servo import ServoConfig, Servos, tune_servos
from arjuna_sim.physics.wheels.tyres import STICTION, sag_of, tune_tyres
from arjuna_sim.physics.world_geoms import add_world

_SOLVER_TOLERANCE = 1e-6
_ARENA = (64_000_000, 1_000_000_000)  # least and most memory for contacts [bytes]


@dataclass(frozen=True)
class Scene:
    """A compiled model.

    Attributes:
        model: The `mujoco.MjModel`.
        base: Address of the robot's root in qpos (7 values) and qvel (6 values).
        rates: How many values of qvel are the robot's; they are the first.
        joint_position: Addresses of the moving joints in qpos, in the robot's order.
        joint_velocity: Addresses of the moving joints in qvel, in the robot's order.
        rollers: Addresses in qpos of what the rollers of wheels have turned.
        names: For each geom the model it belongs to, "" for the robot and the ground.
        is_obstacle: For each geom whether it has such a name, `(G,) bool`.
        is_robot: For each geom whether it is a collision shape of the robot, `(G,) bool`.
        ride_height: Height of the robot's root above the ground when it stands [m].
        steady: Greatest acceleration at which it stands on all its feet and grips [m/s^2].
        servos: The wheels' motors.
    """

    model: Any
    base: tuple[int, int]
    rates: int
    joint_position: NDArray[np.int64]
    joint_velocity: NDArray[np.int64]
    rollers: NDArray[np.int64]
    names: tuple[str, ...]
    is_obstacle: NDArray[np.bool_]
    is_robot: NDArray[np.bool_]
    ride_height: float
    steady: float
    servos: Servos


def build_scene(
    robot: Robot,
    world: World,
    servo: ServoConfig,
    timestep: float,
    entities: tuple[Entity, ...] = (),
) -> Scene:
    """Compile a robot in a world.

    Args:
        robot: The robot.
        world: The world.
        servo: How the wheels are driven.
        timestep: Of the physics [s].
        entities: What moves by itself, was moved or was spawned.

    Raises:
        RobotError: MuJoCo refuses the robot, with its reason.
        WorldError: It refuses the world.
    """
    spec = mujoco.MjSpec()
    _set_physics(spec, timestep)
    spec.option.gravity = world.gravity
    models = add_world(spec, world)
    sag = sag_of(robot, timestep)
    add_robot(spec, robot, servo, sag)
    add_mounts(spec, robot)
    for sensor in robot.settings.sensors:
        if isinstance(sensor, CameraSettings):
            add_camera(spec, sensor)
    owners = [entity.name for entity in entities for _ in range(add_entity(spec, entity))]
    moving = {entity.name for entity in entities if entity.mass > 0.0}
    spec.memory = _memory(sum(owner in moving for owner in owners))
    try:
        model = spec.compile()
    except ValueError as error:
        reason = f"cannot be simulated: {' '.join(str(error).split())}"
        if _is_sound(world):
            raise RobotError(robot.urdf.path, reason) from error
        raise WorldError(world.path, reason) from error
    let_sleep(model, f"body:{robot.urdf.root}")
    standing = tune_tyres(model, robot, sag)
    return _index(model, robot, models, owners, tune_servos(model, robot, servo), standing)


def _memory(geoms: int) -> int:
    """Return the memory for contacts of so many shapes that can be pushed [bytes].

    Where it is short MuJoCo forgets contacts, and what stood on them falls. A shape meets the
    ground in up to four points, of three forces each; solving takes the square of all of them.
    Only what is used is taken from the machine.
    """
    return int(min(_ARENA[0] + 4 * 8 * (4 * 3 * geoms) ** 2, _ARENA[1]))


def _is_sound(world: World) -> bool:
    """Tell whether MuJoCo takes a world without a robot."""
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
    spec.option.tolerance = _SOLVER_TOLERANCE
    # What lies still costs little then, and what stands fast is placed once and not at each step,
    # which takes 8 times as long in a world of 26 000 pieces.
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    spec.compiler.balanceinertia = True
    spec.compiler.degree = False


def _index(
    model: Any,
    robot: Robot,
    models: list[str],
    owners: list[str],
    servos: Servos,
    standing: tuple[float, float],
) -> Scene:
    """Find things; geoms are in the order of their bodies: the world, the robot, the entities."""

    def positions(names: tuple[str, ...]) -> NDArray[np.int64]:
        return np.array([model.joint(name).qposadr[0] for name in names], np.int64)

    moving = robot.moving_joints
    base = model.joint(BODY_JOINT)
    names = [*models, *[""] * (model.ngeom - len(models) - len(owners)), *owners]
    return Scene(
        model,
        (int(base.qposadr[0]), int(base.dofadr[0])),
        int(np.isin(model.body_rootid[model.dof_bodyid], base.bodyid).sum()),
        positions(moving),
        np.array([model.joint(name).dofadr[0] for name in moving], np.int64),
        roller_addresses(model, robot),
        tuple(names),
        np.array([name != "" for name in names]),
        model.geom_group == Group.ROBOT_COLLISION.value,
        *standing,
        servos,
    )
