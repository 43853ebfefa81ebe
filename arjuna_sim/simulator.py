"""The simulator: one robot in one world, advanced tick by tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.camera import Camera, CameraError, Shot
from arjuna_sim.devices.drive import Drive, DriveConfig, Velocity, limited
from arjuna_sim.devices.driving.bases import base_of
from arjuna_sim.devices.further_sensors import FurtherSensors, Reading
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import Odometry
from arjuna_sim.devices.sensors import Sensors, mounted
from arjuna_sim.files.urdf.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.surfaces import surfaces
from arjuna_sim.model.robot import Robot
from arjuna_sim.model.settings import CameraSettings, SensorSettings
from arjuna_sim.model.world import World
from arjuna_sim.observation import Observation
from arjuna_sim.physics.placing import Placer
from arjuna_sim.physics.robot_motion import RobotMotion, Truth
from arjuna_sim.physics.stage import Stage
from arjuna_sim.physics.wheels.footing import footing_notes

_NANOSECONDS = 1_000_000_000


class Simulator:
    """A robot in a world. The same seed and commands give the same observations, bit by bit.

    Args:
        robot: A robot, or its URDF file.
        world: A world, or its SDF file or map.
        config: Everything else.
        rng: Seeds the noise; `reset` rewinds it to its present state.
        spawn: Where the robot starts; the nearest free place if it is blocked.

    Raises:
        RobotError: The robot cannot be simulated.
        WorldError: The world cannot be simulated.
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
        world = world if isinstance(world, World) else load_world(world)
        self.stage = Stage(self.robot, world, config.servo, config.physics_timestep)
        self._motion = RobotMotion(self.stage, self.robot.moving_joints)
        self._placer = Placer(self.stage)
        self._wanted = spawn
        self._choose_spawn()
        self.stage.on_rebuild = lambda: self._sensors.rebind(self.stage.scene.model)
        self._base = base_of(self.robot, config.drive)
        self._drive = Drive(self._limits(config))
        self._cameras: dict[str, Camera] = {}
        self._seeds = rng.bit_generator.random_raw(4)
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
    def notes(self) -> tuple[str, ...]:
        """What the robot's and the world's file say and the simulation leaves out."""
        read = tuple(note.text for note in self.robot.notes + self.world.notes)
        return read + footing_notes(self.stage.scene.steady) + self._spawn_notes

    def step(self, command: Velocity | None = None) -> Observation:
        """Advance one tick.

        Args:
            command: A new command, or None to go on with the last until it times out.

        Returns:
            What the robot's sensors and the world say at the tick's end.
        """
        if command is not None:
            self._drive.command(command, self.stage.elapsed)
        wanted = self._base.reachable(self._drive.velocity(self.stage.elapsed, self.config.tick))
        self._motion.turn_wheels(self._base.speeds(wanted), self._base.angles(wanted))
        readings = self._advance()
        return Observation(
            self.time,
            self._odometry.update(
                self.wheel_angles(), self.config.tick, self._motion.steering_angles()
            ),
            self._motion.joint_states(),
            readings[-1] if readings else None,
            self._sensors.scan(self.stage.data, self.time),
            self.truth(),
            self.stage.contacts(),
            tuple(readings[:-1]),
        )

    def _advance(self) -> list[ImuReading]:
        """Run a tick's physics; an IMU that is faster reads on the way, after a whole step."""
        start, tick, steps = self.time, self.config.tick, self.config.substeps
        slices = steps if self._sensors.is_imu_faster(tick) else 1
        self._ticks += 1
        readings = []
        for i in range(1, slices + 1):
            self.stage.advance(steps // slices)
            now = self.time if i == slices else start + i * tick / slices
            due = self._sensors.is_imu_due(now)
            if due or i == slices:
                self._motion.refresh()
            if due:
                readings.append(self._sensors.imu(self.stage.data, now))
        return readings

    def adjust(self, config: SimulatorConfig) -> None:
        """Take new limits of the drive and noises of the odometry, while it runs."""
        self.config = config
        self._drive.config = self._limits(config)
        self._odometry.config = config.odometry

    def _limits(self, config: SimulatorConfig) -> DriveConfig:
        return limited(config.drive, self.robot.drive, self.stage.scene.steady)

    def truth(self) -> Truth:
        """Return where the robot is now."""
        return self._motion.truth()

    def wheel_angles(self) -> tuple[float, ...]:
        """Return what the encoders count [rad].

        Of a base of two sides how far the left and the right wheels have turned forward, in the
        mean; else how far each wheel's joint has turned.
        """
        return tuple(self._base.encoders(self._motion.wheel_angles()).tolist())

    def picture(
        self, color: bool = True, depth: bool = False, camera: CameraSettings | None = None
    ) -> Shot:
        """Return what a camera sees now: colours, distances or both.

        Args:
            color: Whether the colours are wanted.
            depth: Whether the distances are wanted.
            camera: One of the robot's; its first if None.

        Raises:
            CameraError: The robot has no camera, or this machine cannot draw.
        """
        camera = camera or self.robot.settings.camera
        if camera is None:
            raise CameraError(f"{self.robot.urdf.path}: has no camera sensor")
        if camera.name not in self._cameras:
            self._cameras[camera.name] = Camera(camera)
        found = self._cameras[camera.name]
        return found.shoot(self.stage.scene.model, self.stage.data, color, depth)

    def sense(self, sensor: SensorSettings) -> Reading:
        """Return what one of the robot's further sensors says now."""
        return self._further.read(sensor, self.stage.scene.model, self.stage.data, self.time)

    def surfaces(self) -> NDArray[np.float64]:
        """Return the world's true surfaces at the lidar's height.

        Returns:
            Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m] in the world's frame.
        """
        lidar = self.robot.settings.lidar
        above = 0.0 if lidar is None else mounted(self.robot, lidar).position[2]
        height = self.stage.scene.ride_height + above
        return surfaces(self.world, height)

    def obstacles_at(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of the world's models that the robot would touch at a pose."""
        touched = self._placer.touched(pose)
        self._motion.refresh()
        return touched

    def set_pose(self, pose: SE2) -> None:
        """Pick the robot up and put it down at rest; its odometry does not notice."""
        self._motion.put(self._placer.place(pose))
        self._drive.reset()
        self._sensors.settle()
        self._further.settle()

    def reset(self) -> None:
        """Return to the start: time 0, the world as it was read, noise rewound."""
        self._ticks = 0
        self.stage.restore()
        config, seeds = self.config, self._seeds
        model = self.stage.scene.model
        self._sensors = Sensors(self.robot, model, config.lidar, config.imu, seeds[:2])
        self._further = FurtherSensors(
            self.robot, self.world.earth, config.lidar, config.imu, int(seeds[3])
        )
        rng = np.random.default_rng(int(seeds[2]))
        self._odometry = Odometry(config.odometry, self._base, rng)
        self.set_pose(self.spawn)

    def reset_time(self) -> None:
        """Set the time to 0, and leave everything where it is."""
        self._ticks = 0

    def reset_state(self) -> None:
        """Put the robot and all entities that are there to their starts; time goes on."""
        self.stage.rewind()
        self._odometry.reset()
        self.set_pose(self.spawn)

    def load_world(self, world: World) -> None:
        """Replace the world and return to the start.

        Raises:
            RobotError: MuJoCo refuses the world; nothing has changed.
        """
        self.stage.load(world)
        self._choose_spawn()
        self.reset()

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

    def close(self) -> None:
        """Free what the cameras hold."""
        for camera in self._cameras.values():
            camera.close()
