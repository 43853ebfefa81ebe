"""A batch: copies of one robot and world, stepped together on a GPU or on the CPU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from arjuna_core.arrays import Bools, Floats, Singles
from arjuna_core.errors import ConfigError, RobotError, WorldError
from arjuna_core.se2 import SE2
from arjuna_sim.batch.drive import BatchDrive
from arjuna_sim.batch.kernels import aim_beams, find_touched, measure
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.bases import base_of
from arjuna_sim.devices.driving.controller import limited
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.model.entities import moving_entities
from arjuna_sim.model.geometry.shapes import Group, Kind
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.world import World
from arjuna_sim.physics.placing import Placer
from arjuna_sim.physics.robot_motion import truth_of_each
from arjuna_sim.physics.running import in_single_precision
from arjuna_sim.physics.stage import Stage
from arjuna_sim.physics.wheels.servo import turn_each

CONTACTS = 48
"""Contacts of a robot for which there is memory, in the mean of all."""
_ROWS = 3  # of the solver for a contact: along its normal and across
_VARIED = ("body_mass", "body_inertia", "body_subtreemass", "geom_friction")


@dataclass(frozen=True)
class Variation:
    """Factors by which robots and floors differ, drawn uniformly for each copy.

    The tyres and the motors are those of the robot's file, whatever it weighs.
    """

    friction: tuple[float, float] = (1.0, 1.0)
    mass: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        """Refuse factors that no robot could have."""
        for name, (low, high) in vars(self).items():
            if not 0.0 < low <= high < np.inf:
                raise ConfigError(f"'{name}' is {low:g} to {high:g}; valid: 0 < low <= high")


class BatchState(NamedTuple):
    """The robots at a tick's end.

    Attributes:
        poses: True ones, seen from above, `(N, 3) float64` [m, m, rad].
        velocities: True ones, forward, to the left and turning, `(N, 3)` [m/s, m/s, rad/s].
        measured: The velocities by the wheels' encoders, `(N, 3)`.
        touched: Whether a robot touches something that it does not stand on, `(N,) bool`.
        lost: Whether its contacts could not be solved in 32 bits: its other values are those of no
            robot, until it is put down again, `(N,) bool`.
    """

    poses: Floats
    velocities: Floats
    measured: Floats
    touched: Bools
    lost: Bools


class Batch:
    """Copies of one robot, each in a world of its own.

    The same seed, starts and commands give the same states and scans on the same device, bit by
    bit. On the CPU what a robot does is its own, however many there are.

    Args:
        starts: Where they stand, `(N, 3)` [m, m, rad].
        seed: Of all noise and of the variation; robot i draws its own from `(seed, i)`.
        device: Warp's name of it: `cpu`, `cuda` or `cuda:1`.

    Attributes:
        friction: The factor of each robot's friction, `(N,) float64`.
        mass: The factor of its mass, `(N,) float64`.

    Raises:
        RobotError: It is of a kind that a batch does not take.
        WorldError: Something in it is.
        ConfigError: A parameter asks for what a batch does not do, or the device is not there.
    """

    def __init__(
        self,
        robot: RobotModel,
        world: World,
        starts: Floats,
        config: SimulatorConfig | None = None,
        variation: Variation | None = None,
        seed: int = 0,
        device: str = "cpu",
    ) -> None:
        import mujoco_warp  # takes 2 s

        self.config = config = config or SimulatorConfig()
        self._lidar = _taken(robot, world, config)
        self._device, self.count = device_of(device), len(starts)
        self._stage = Stage({SOLO: robot}, world, config.servo, config.physics_timestep)
        self._placer = Placer(self._stage, SOLO)
        scene = self._stage.scene
        self._found = scene.robots[SOLO]
        limits = limited(config.drive, robot.drive, self._found.support.steady)
        most = [robot.urdf.joints[name].max_speed or np.inf for name in robot.drive.wheels]
        angle = 2.0 * np.pi / config.odometry.ticks_per_revolution
        base = base_of(robot, config.drive)
        self._drive = BatchDrive(base, limits, np.array(most), config.tick, angle, self.count)
        rngs = [np.random.default_rng([seed, i]) for i in range(self.count)]
        self._draw(rngs, variation or Variation())
        self._mjw = mujoco_warp
        with wp.ScopedDevice(self._device):
            self._seeds = wp.zeros(self.count, dtype=int)
            self._make_worlds(scene)
            self._make_beams(scene.model)
            self._advance()  # compiles what is recorded then: launches alone would take longer
            with wp.ScopedCapture() as recording:
                self._advance()
        self._tick = recording.graph
        self.reseed(seed)
        self.put(starts)

    def reseed(self, seed: int) -> None:
        """Rewind the noise to that of a seed; frictions and masses stay."""
        rngs = [np.random.default_rng([seed, i, 1]) for i in range(self.count)]
        self._seeds.assign(np.array([rng.integers(2**31) for rng in rngs], np.int32))
        self._scans = 0

    def _draw(self, rngs: list[np.random.Generator], variation: Variation) -> None:
        drawn = [(rng.uniform(*variation.friction), rng.uniform(*variation.mass)) for rng in rngs]
        self.friction, self.mass = np.array(drawn).T

    def _make_worlds(self, scene: Any) -> None:
        model = in_single_precision(scene.model)
        self._model = self._mjw.put_model(model, dict.fromkeys(_VARIED, self.count))
        self._model.opt.deterministic = int(self._mjw.DeterminismType.ALL)  # on a GPU too
        for name in _VARIED:
            field = getattr(self._model, name)
            factors = np.ones((self.count, *field.numpy().shape[1:]))
            if name == "geom_friction":
                factors[..., 0] = self.friction[:, None]
            else:
                factors *= self.mass.reshape(-1, *[1] * (factors.ndim - 1))
            field.assign((getattr(model, name) * factors).astype(np.float32))
        rows = _ROWS * CONTACTS
        self._data = self._mjw.make_data(model, self.count, nconmax=CONTACTS, njmax=rows)
        self._rest = model.qpos0.astype(np.float32)
        self._is_solid = wp.array(self._found.is_solid.astype(np.int32), dtype=int)
        self._is_obstacle = wp.array(scene.is_obstacle.astype(np.int32), dtype=int)
        self._touched = wp.zeros(self.count, dtype=int)

    def _make_beams(self, model: Any) -> None:
        lidar = self._lidar
        angles = np.linspace(lidar.angle_min, lidar.angle_max, lidar.samples)
        beams = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))
        shape = self.count, lidar.samples
        self._site = int(model.site(lidar.site).id)
        self._beams = wp.array(beams.astype(np.float32), dtype=wp.vec3)
        self._rays = [wp.empty(shape, dtype=wp.vec3) for _ in range(2)]
        seen = Group.WORLD_VISUAL if lidar.rendered else Group.WORLD_COLLISION
        groups = [float(group == seen.value) for group in range(6)]
        self._seen = wp.types.vector(6, float)(*groups)
        self._own = wp.full(lidar.samples, -1, dtype=int)
        self._hits = [wp.empty(shape, dtype=kind) for kind in (float, int, wp.vec3)]
        self._ranges = wp.empty(shape, dtype=float)

    @property
    def qpos(self) -> Singles:
        """MuJoCo's positions of all joints of each robot, `(N, nq) float32`."""
        return np.array(self._data.qpos.numpy())

    def put(self, poses: Floats, which: Bools | None = None) -> None:
        """Put robots down at rest, whatever they would stand in; all, or those that are meant.

        Args:
            poses: `(N, 3)` [m, m, rad]; of the others they are not read.
            which: `(N,) bool`.
        """
        which = np.ones(self.count, np.bool_) if which is None else which
        data, at = self._data, self._found.base[0]
        qpos = data.qpos.numpy()
        qpos[which] = self._rest
        for i in np.flatnonzero(which):
            root = self._placer.root_pose(SE2.from_array(poses[i]))
            qpos[i, at : at + 7] = (*root.position, *root.quaternion)
        data.qpos.assign(qpos)
        for field in (data.qvel, data.act, data.ctrl, data.qacc_warmstart):
            values = field.numpy()
            values[which] = 0.0
            field.assign(values)
        self._drive.restart(which)
        with wp.ScopedDevice(self._device):
            self._mjw.kinematics(self._model, data)

    def step(self, commands: Floats) -> BatchState:
        """Advance all by a tick of commands `(N, 3)`: forward, left, turning [m/s, m/s, rad/s].

        Raises:
            CommandError: One is not finite.
        """
        data, servos = self._data, self._found.servos
        qpos, qvel, act, ctrl = (
            field.numpy() for field in (data.qpos, data.qvel, data.act, data.ctrl)
        )
        limits = servos.position, servos.velocity, servos.lead, servos.reach, servos.response_time
        wanted, setpoint = act[:, servos.sums], ctrl[:, servos.motors]
        turn_each(qpos, qvel, wanted, setpoint, self._drive.speeds(commands), *limits)
        data.act.assign(act)
        data.ctrl.assign(ctrl)
        with wp.ScopedDevice(self._device):
            wp.capture_launch(self._tick)
        qpos, qvel = data.qpos.numpy().astype(np.float64), data.qvel.numpy().astype(np.float64)
        truth = truth_of_each(qpos, qvel, *self._found.base)
        measured = self._drive.velocities(qpos[:, servos.position])
        touched = self._touched.numpy().astype(np.bool_)
        lost = np.asarray(~np.isfinite(truth).all(axis=1))
        return BatchState(truth[:, :3], truth[:, [3, 8, 4]], measured, touched, lost)

    def _advance(self) -> None:
        """Run a tick's physics."""
        data, pairs = self._data, self._data.contact
        for _ in range(self.config.substeps):
            self._mjw.step(self._model, data)
        self._mjw.kinematics(self._model, data)
        self._touched.zero_()
        contacts = [data.nacon, pairs.geom, pairs.worldid, pairs.frame, pairs.dist]
        kinds = [self._is_solid, self._is_obstacle]
        wp.launch(find_touched, data.naconmax, [*contacts, *kinds], [self._touched])

    def scan(self) -> Singles:
        """Return what the lidars read now by REP 117, `(N, B) float32` [m]."""
        lidar, config, data, shape = self._lidar, self.config.lidar, self._data, self._ranges.shape
        noise = lidar.noise if config.noise < 0.0 else config.noise
        self._scans += 1
        with wp.ScopedDevice(self._device):
            where = [self._site, self._beams, data.site_xpos, data.site_xmat]
            wp.launch(aim_beams, shape, where, self._rays)
            self._mjw.rays(self._model, data, *self._rays, self._seen, True, self._own, *self._hits)
            limits = [noise, config.dropout, lidar.range_min, lidar.range_max]
            given = [self._hits[0], self._seeds, self._scans, *limits]
            wp.launch(measure, shape, given, [self._ranges])
        return np.array(self._ranges.numpy())


def device_of(name: str) -> Any:
    """Return Warp's device of a name.

    Raises:
        ConfigError: It is not there.
    """
    try:
        return wp.get_device(name)
    except (RuntimeError, ValueError) as error:
        valid = ", ".join(device.alias for device in wp.get_devices())
        raise ConfigError(f"device '{name}' is not there; valid: {valid}") from error


def _taken(robot: RobotModel, world: World, config: SimulatorConfig) -> LidarSettings:
    """Return the lidar of a robot that a batch takes, in a world that it takes."""
    if config.lidar.sweep:
        raise ConfigError("'lidar.sweep' is true; a batch casts all beams at once: valid: false")
    if config.odometry.encoder_noise > 0.0:
        raise ConfigError("'odometry.encoder_noise' is above 0; valid for a batch: 0")
    path, lidar = robot.urdf.path, robot.settings.first(LidarSettings)
    if robot.drive.kind is not DriveKind.SIDES:
        problem = f"a batch does not take {robot.drive.kind.value}"
        raise RobotError(path, f"{problem}; valid: {DriveKind.SIDES.value} drive")
    if robot.anchored:
        raise RobotError(path, "a batch does not take a robot that is fixed to the world")
    if lidar is None:
        raise RobotError(path, "a batch does not take a robot without a planar lidar")
    for name, entity in moving_entities(world).items():
        kind = "which moves" if entity.trajectory is None else "a person"
        raise WorldError(
            world.path, f"a batch does not take '{name}', {kind}; valid: static models"
        )
    for body in world.bodies:
        if body.part.shape.kind in (Kind.MESH, Kind.TERRAIN):
            problem = f"a batch does not take '{body.model}', a {body.part.shape.kind.name.lower()}"
            raise WorldError(world.path, f"{problem}; valid: boxes, cylinders, spheres and planes")
    return lidar
