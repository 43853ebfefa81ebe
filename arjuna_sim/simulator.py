"""The simulator: one robot in one world, advanced tick by tick."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.devices.camera import Camera, CameraError
from arjuna_sim.devices.drive import Drive, DriveConfig, Velocity, kinematics_of, limited
from arjuna_sim.devices.imu import ImuConfig, ImuReading
from arjuna_sim.devices.lidar import LidarConfig
from arjuna_sim.devices.odometry import Odometry, OdometryConfig
from arjuna_sim.devices.sensors import Sensors
from arjuna_sim.files.sdf.sdf import World
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.robot import Robot, ServoConfig, load_robot
from arjuna_sim.model.world import surfaces
from arjuna_sim.observation import JointStates, Observation, Truth
from arjuna_sim.physics.placing import Placer
from arjuna_sim.physics.scene import Scene
from arjuna_sim.physics.stage import Stage

_NANOSECONDS = 1_000_000_000
_STICTION = 10  # solver iterations that make friction hold: who parks on a slope stays there


@dataclass(frozen=True)
class SimulatorConfig:
    """Everything about the simulation that is not in the robot's or the world's file."""

    tick: float = param(
        0.02, "Time that one step advances.", unit="s", minimum=0.001, maximum=0.1, read_only=True
    )
    physics_timestep: float = param(
        0.004,
        "Time step of the physics; the tick must be a whole number of them.",
        unit="s",
        minimum=0.0001,
        maximum=0.01,
        read_only=True,
    )
    drive: DriveConfig = field(default_factory=DriveConfig)
    odometry: OdometryConfig = field(default_factory=OdometryConfig)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    imu: ImuConfig = field(default_factory=ImuConfig)
    servo: ServoConfig = field(default_factory=ServoConfig)

    def __post_init__(self) -> None:
        """Refuse a tick, in which the wheels are controlled, that physics steps do not divide."""
        _substeps(self)


class Simulator:
    """A robot in a world. The same seed and commands give the same observations, bit by bit.

    Args:
        robot: A robot, or its URDF file.
        world: A world, or its SDF file or map.
        config: Everything else.
        rng: Where chance comes from; `reset` rewinds to its present state.
        spawn: Where the robot starts; the nearest free place if it is blocked.

    Raises:
        RobotError: The robot cannot be simulated.
        WorldError: The world cannot be simulated.
        ConfigError: The tick is no whole number of physics steps.
    """

    def __init__(
        self,
        robot: str | Path | Robot,
        world: str | Path | World,
        config: SimulatorConfig,
        rng: np.random.Generator,
        spawn: SE2 = IDENTITY,
    ) -> None:
        self.config = config
        self.robot = robot if isinstance(robot, Robot) else load_robot(robot)
        self._substeps = _substeps(config)
        world = world if isinstance(world, World) else load_world(world)
        self.stage = Stage(self.robot, world, config.servo, config.physics_timestep)
        self._placer = Placer(self.stage)
        self._wanted = spawn
        self._choose_spawn()
        self.stage.on_rebuild = self._on_rebuild
        self.kinematics = kinematics_of(self.robot.drive, config.drive)
        self._drive = Drive(limited(config.drive, self.robot.drive), self.kinematics)
        self._camera: Camera | None = None
        self._seeds = rng.bit_generator.random_raw(3)
        self.reset()

    @property
    def time(self) -> float:
        """Simulated time since the start or the last reset [s]."""
        return self._ticks * round(self.config.tick * _NANOSECONDS) / _NANOSECONDS

    @property
    def world(self) -> World:
        """The world as it was read."""
        return self.stage.world

    @property
    def _scene(self) -> Scene:
        return self.stage.scene

    @property
    def _data(self) -> Any:
        return self.stage.data

    @property
    def notes(self) -> tuple[str, ...]:
        """What the robot's and the world's file say and the simulation leaves out."""
        return self.robot.notes + self.world.notes + self._spawn_notes

    def reset(self) -> None:
        """Return to the start: time 0, the world as it was read, chance rewound."""
        self._ticks = 0
        self.stage.restore()
        self._sensors = self._start_sensors()
        self._odometry = Odometry(
            self.config.odometry, self.kinematics, np.random.default_rng(int(self._seeds[2]))
        )
        self.set_pose(self.spawn)

    def reset_time(self) -> None:
        """Set the time to 0, and leave everything where it is."""
        self._ticks = 0

    def reset_state(self) -> None:
        """Put the robot and all entities that are there to their starts; time goes on."""
        self.stage.rewind()
        self._odometry.reset((0.0, 0.0))
        self.set_pose(self.spawn)

    def load_world(self, world: World) -> None:
        """Replace the world and return to the start.

        Raises:
            RobotError: MuJoCo refuses the world; nothing has changed.
        """
        self.stage.load(world)
        self._choose_spawn()
        self.reset()

    def set_pose(self, pose: SE2) -> None:
        """Pick the robot up and put it down at rest; its odometry does not notice."""
        placed = self._placer.place(pose)
        at, _ = self._scene.base
        self._data.qpos[at : at + 3] = placed.position
        self._data.qpos[at + 3 : at + 7] = placed.quaternion
        self._data.qvel[: self._scene.rates] = 0.0
        self._data.qacc_warmstart[: self._scene.rates] = 0.0
        self._drive.reset()
        self._refresh()
        self._sensors.settle()

    def obstacles_at(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of the world's models that the robot would touch at a pose."""
        touched = self._placer.touched(pose)
        self._refresh()
        return touched

    def _choose_spawn(self) -> None:
        """Start at the pose that was asked for, or nearest to it where the robot can stand."""
        wanted = self._wanted
        self.spawn = self._placer.nearest_free(wanted)
        self._spawn_notes: tuple[str, ...] = ()
        if self.spawn != wanted:
            names = ", ".join(self._placer.touched(wanted))
            self._spawn_notes = (
                f"the start ({wanted.x:.4g}, {wanted.y:.4g}) is inside {names}: the robot starts"
                f" at ({self.spawn.x:.4g}, {self.spawn.y:.4g})",
            )

    def step(self, command: Velocity | None = None) -> Observation:
        """Advance one tick.

        Args:
            command: A new command, or None to go on with the last until it times out.

        Returns:
            What the robot's sensors and the world say at the tick's end.
        """
        if command is not None:
            self._drive.command(command, self.stage.elapsed)
        self._turn_wheels()
        readings = self._advance()
        return Observation(
            self.time,
            self._odometry.update(self.wheel_angles(), self.config.tick),
            self._joint_states(),
            readings[-1] if readings else None,
            self._sensors.scan(self._data, self.time),
            self.truth(),
            self.stage.contacts(),
            tuple(readings[:-1]),
        )

    def _advance(self) -> list[ImuReading]:
        """Run a tick's physics; an IMU that is faster reads on the way, after a whole step."""
        start, slices = self.time, self._substeps
        if not self._sensors.is_imu_faster(self.config.tick):
            slices = 1
        readings = []
        for i in range(1, slices + 1):
            self.stage.advance(self._substeps // slices)
            now = start + i * self.config.tick / slices
            if i == slices:
                self._ticks += 1
                now = self.time
            due = self._sensors.is_imu_due(now)
            if due or i == slices:
                self._refresh()
            if due:
                readings.append(self._sensors.imu(self._data, now))
        return readings

    def truth(self) -> Truth:
        """Return where the robot is now."""
        at, rate = self._scene.base
        x, y, z, *quaternion = self._data.qpos[at : at + 7].tolist()
        pose = Pose3((x, y, z), (quaternion[0], quaternion[1], quaternion[2], quaternion[3]))
        forward = pose.rotation()[:, 0]
        roll, pitch, yaw = pose.rpy()
        v = float(forward @ self._data.qvel[rate : rate + 3])
        return Truth(SE2(x, y, yaw), v, float(self._data.qvel[rate + 5]), z, roll, pitch)

    def wheel_angles(self) -> tuple[float, float]:
        """Return how far the left and the right wheels have turned forward, in the mean [rad]."""
        scene, angles = self._scene, self._data.qpos
        return (
            float(angles[scene.left] @ scene.left_sign) / max(1, len(scene.left)),
            float(angles[scene.right] @ scene.right_sign) / max(1, len(scene.right)),
        )

    def picture(self) -> NDArray[np.uint8]:
        """Return what the camera sees now, `(height, width, 3) uint8` RGB.

        Raises:
            CameraError: The robot has no camera, or this machine cannot draw.
        """
        if self.robot.settings.camera is None:
            raise CameraError(f"{self.robot.urdf.path}: has no camera sensor")
        if self._camera is None:
            self._camera = Camera(self._scene.model, self.robot.settings.camera)
        return self._camera.render(self._data)

    def close(self) -> None:
        """Free what the camera holds."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def surfaces(self) -> NDArray[np.float64]:
        """Return the world's true surfaces at the lidar's height.

        Returns:
            Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m] in the world's frame.
        """
        lidar = self.robot.settings.lidar
        link = self.robot.urdf.root if lidar is None else lidar.link
        height = self._scene.ride_height + self.robot.urdf.T_root(link).position[2]
        return surfaces(self.world, height)

    def _start_sensors(self) -> Sensors:
        """Build the sensors with rewound chance."""
        config = self.config
        return Sensors(self.robot, self._scene.model, config.lidar, config.imu, self._seeds[:2])

    def _on_rebuild(self) -> None:
        """Go on with the stage's new model."""
        self.close()
        self._sensors.rebind(self._scene.model)

    def _turn_wheels(self) -> None:
        left, right = self._drive.wheel_speeds(self.stage.elapsed, self.config.tick)
        count = len(self._scene.left)
        self._data.ctrl[:count] = left * self._scene.left_sign
        self._data.ctrl[count:] = right * self._scene.right_sign
        self._scene.model.opt.noslip_iterations = _STICTION if left == right == 0.0 else 0

    def _refresh(self) -> None:
        """Bring places and velocities up to the end of the tick."""
        mujoco.mj_kinematics(self._scene.model, self._data)
        mujoco.mj_comPos(self._scene.model, self._data)
        mujoco.mj_comVel(self._scene.model, self._data)

    def _joint_states(self) -> JointStates:
        scene = self._scene
        return JointStates(
            self.robot.moving_joints,
            self._data.qpos[scene.joint_position],
            self._data.qvel[scene.joint_velocity],
        )


def _substeps(config: SimulatorConfig) -> int:
    ratio = config.tick / config.physics_timestep
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
        raise ConfigError(
            f"'tick' {config.tick} s must be a whole number of 'physics_timestep'"
            f" {config.physics_timestep} s"
        )
    return round(ratio)
