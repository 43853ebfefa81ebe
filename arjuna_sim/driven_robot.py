"""A driven robot on a stage: its drive, its devices, and what it observes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.device import mounted
from arjuna_sim.devices.driving.bases import WheelSpeeds, base_of
from arjuna_sim.devices.driving.controller import Drive, Limits, limited
from arjuna_sim.devices.driving.joints import JointControllers
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import Odometry, OdometryEstimate
from arjuna_sim.devices.sensor_suite import SensorSuite
from arjuna_sim.devices.sensors.battery import BatterySettings
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.model.geometry.walls import enclosure_of, surfaces
from arjuna_sim.model.notes import gathered
from arjuna_sim.model.robot import RobotModel, inscribed_radius
from arjuna_sim.model.settings import DriveKind, S, SensorSettings
from arjuna_sim.physics.placing import EDGE, Placer
from arjuna_sim.physics.robot_motion import JointStates, RobotMotion, Truth
from arjuna_sim.physics.stage import Stage
from arjuna_sim.staged_sensors import StagedSensors


class Observation(NamedTuple):
    """The readings of one tick.

    Attributes:
        time: At the tick's end [s].
        joints: All joints that move.
        imu: The last reading, where one was due.
        scan: A sweep, where one was due.
        truth: The robot's true pose and motion.
        contacts: Names of the world's models that the robot touches, sorted; never the ground.
        imu_before: The readings before the last, where the IMU is faster than the tick.
    """

    time: float
    odometry: OdometryEstimate
    joints: JointStates
    imu: ImuReading | None
    scan: Scan | None
    truth: Truth
    contacts: tuple[str, ...]
    imu_before: tuple[ImuReading, ...] = ()


class DrivenRobot(StagedSensors):
    """One robot of a simulation.

    Args:
        name: Its name on the stage, which holds it as `model.below(name)`.
        seeds: Four, of all its noise.
        wanted: Where it starts; None if that was not asked for.

    Attributes:
        spawn: Its start: where that was wanted, or the nearest free pose.
        controllers: What commands its driven joints.
        seeds: Of the noise from the next `begin` on.
    """

    def __init__(
        self,
        name: str,
        model: RobotModel,
        stage: Stage,
        config: SimulatorConfig,
        seeds: NDArray[np.uint64],
        wanted: SE2 | None,
    ) -> None:
        super().__init__(stage, config, int(seeds[3]))
        self.name, self.model, self.spawn, self.seeds = name, model, wanted or IDENTITY, seeds
        self._wanted = wanted
        pairs = zip(map(_key, model.settings.sensors), self.settings, strict=True)
        self._staged: dict[tuple[str, str, str], Any] = dict(pairs)
        self._motion = RobotMotion(stage, name, model.moving_joints)
        self._placer = Placer(stage, name)
        self._base = base_of(model, config.drive)
        along_arcs = model.drive.kind is DriveKind.STEERED
        self._drive, self._wheels = Drive(self.limits, along_arcs), WheelSpeeds(model, self._base)
        self.setpoint = Velocity()
        batteries = (s for s in model.settings.sensors if isinstance(s, BatterySettings))
        self._batteries = tuple(batteries)
        self._spawn_notes: tuple[str, ...] = ()
        self.begin()

    @property
    def notes(self) -> tuple[str, ...]:
        """Parts of its file that the simulation leaves out, and faults of its stance."""
        read = gathered(self.model.notes)
        return read + self._stage.scene.robots[self.name].support.faults + self._spawn_notes

    def begin(self) -> None:
        """Make new devices, their noise rewound."""
        config, seeds, self.seed = self._config, self.seeds, int(self.seeds[3])
        super().begin()
        staged = self._stage.robots[self.name]
        self._sensors = SensorSuite(staged.settings, self._mount, seeds[:2])
        self._felt: list[ImuReading] = []
        self._is_empty = False
        self.is_imu_faster = self._sensors.is_imu_faster(config.tick)
        rng = np.random.default_rng(int(seeds[2]))
        self._odometry = Odometry(config.odometry, self._base, rng)
        self.controllers = JointControllers(self.model)
        self._rest_joints()

    def _rest_joints(self) -> None:
        """Put its driven joints where they start, commanded by nothing."""
        self.controllers.rest(self.controllers.initial)
        self._motion.set_joints(self.controllers.initial)

    def rebind(self) -> None:
        """Continue with the stage's new MuJoCo model."""
        super().rebind()
        self._motion.rebind()
        for device in self._sensors.devices:
            device.rebind(self._stage.scene.model)

    def adjust(self, config: SimulatorConfig) -> None:
        """Take new limits of the drive and noises of the odometry, while it runs."""
        self._config = config
        self._drive.limits = self.limits
        self._odometry.config = config.odometry

    @property
    def limits(self) -> Limits:
        """The limits of its commands."""
        steady = self._stage.scene.robots[self.name].support.steady
        return limited(self._config.drive, self.model.drive, steady)

    def drive(self, command: Velocity | None) -> None:
        """Set the wheels' speeds by a tick's command, or by the last one until it times out."""
        elapsed, tick = self._stage.elapsed, self._config.tick
        if command is not None:
            self._drive.command(command, elapsed)
        asked = Velocity() if self._is_empty else self._drive.velocity(elapsed, tick)
        wanted = self._base.reachable(asked)
        self.setpoint = self._wheels.slowed(wanted)
        speeds = self._base.speeds_at(self.setpoint, self._motion.steering_angles())
        wheels = self.controllers.of_wheels(speeds, self._base.angles(self.setpoint))
        self._motion.turn_wheels(*wheels)
        if self.controllers.names:
            at = self._motion.driven_joints()
            self._motion.drive_joints(self.controllers.update(elapsed, tick, at))

    @property
    def elapsed(self) -> float:
        """The time by which its controllers go: of the physics since the last restart [s]."""
        return self._stage.elapsed

    def take_cuts(self) -> tuple[str, ...]:
        """Return which limits have cut its commands, each once."""
        return self._drive.take_cuts() + self._wheels.take_cuts()

    def feel(self, now: float) -> None:
        """Read its IMU at a time [s] within a tick, if it is due."""
        reading = self._sensors.imu(self._stage.data, now)
        if reading is not None:
            self._felt.append(reading)

    def observe(self, now: float) -> Observation:
        """Return what a tick brought that ends at a time [s]."""
        self.feel(now)
        readings, self._felt = self._felt, []
        angles = self._motion.steering_angles()
        self._is_empty = any(self.sense(each, now).charge == 0.0 for each in self._batteries)
        return Observation(
            now,
            self._odometry.update(self._encoders(), self._config.tick, angles),
            self.joints(),
            readings[-1] if readings else None,
            self._sensors.scan(self._stage.data, now),
            self.truth(),
            self._stage.contacts(self.name),
            tuple(readings[:-1]),
        )

    def joints(self) -> JointStates:
        """Return the positions and velocities of its moving joints now."""
        return self._motion.joint_states()

    def truth(self) -> Truth:
        """Return where it is now."""
        return self._motion.truth()

    def wheel_angles(self) -> tuple[float, ...]:
        """Return what the encoders count [rad].

        Of a base of two sides how far the left and the right wheels have turned forward, in the
        mean; else how far each wheel's joint has turned.
        """
        return tuple(self._encoders().tolist())

    def _encoders(self) -> Floats:
        return self._base.encoders(self._motion.wheel_angles())

    @property
    def settings(self) -> tuple[SensorSettings, ...]:
        """Its sensors, as the stage knows them."""
        return self._stage.robots[self.name].settings.sensors

    def staged(self, sensor: S) -> S:
        """Return one of its sensors as the stage knows it."""
        found: S = self._staged[_key(sensor)]
        return found

    def _mounted(self, sensor: SensorSettings) -> Pose3:
        return mounted(self._stage.robots[self.name], sensor)

    def surfaces(self) -> Floats:
        """Return the world's true surfaces at the lidar's height.

        Returns:
            Line segments `(N, 4) float64` of `(x0, y0, x1, y1)` [m] in the world's frame.
        """
        lidar = self.model.settings.first(LidarSettings)
        above = 0.0 if lidar is None else mounted(self.model, lidar).position[2]
        height = self._stage.scene.robots[self.name].support.ride_height + above
        return surfaces(self._stage.world, height)

    def obstacles_at(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of what it would touch at a pose."""
        touched = self._placer.touched(pose)
        self._stage.settle()
        return touched

    def set_pose(self, pose: SE2) -> None:
        """Pick it up and put it down at rest; its odometry does not notice."""
        self._motion.put(self._placer.root_pose(pose))
        self._drive.reset()
        for device in (*self._sensors.devices, *self._devices.values()):
            device.settle()

    def lift(self, height: float) -> None:
        """Lift it to a height [m], clear of all others."""
        self._motion.put(Pose3((0.0, 0.0, height)))

    def return_to_start(self) -> None:
        """Put it where it starts, the odometry at its origin."""
        self._odometry.reset()
        self._rest_joints()
        self.set_pose(self.spawn)

    def resume(self, pose: SE2, odometry: SE2) -> None:
        """Put it somewhere, its odometry at a pose."""
        self._odometry.reset(pose=odometry)
        self.set_pose(pose)

    def choose_spawn(self) -> None:
        """Start at the pose that was asked for, or nearest to it where it can stand."""
        wanted = self._wanted or IDENTITY
        self.spawn = self._placer.nearest_free(self._wanted)
        self._spawn_notes = ()
        if self.spawn != wanted:
            touched = self._placer.touched(wanted)
            inside = f"inside {', '.join(touched)}" if touched else "without room to turn"
            where = f"at {EDGE}" if touched == (EDGE,) else inside
            self._spawn_notes = (
                f"the start {_place(wanted)} is {where}: the robot starts at {_place(self.spawn)}",
            )
        self._spawn_notes += self._if_outside()

    def _if_outside(self) -> tuple[str, ...]:
        """Return what to note of a start that is outside the world's walls."""
        spawn = self.spawn
        enclosure = enclosure_of(self.surfaces(), inscribed_radius(self.model))
        if enclosure is None or not enclosure.is_outside(spawn.x, spawn.y):
            return ()
        inside = enclosure.nearest_inside(spawn.x, spawn.y).tolist()
        fine = ((x, y) for x, y in inside if not self._placer.touched(SE2(x, y, spawn.theta)))
        hint = next((f"; inside is ({x:.2f}, {y:.2f})" for x, y in fine), "")
        return (
            f"the start {_place(spawn)} is outside the world's walls: nothing inside can be reached"
            f" from there{hint}",
        )


def _place(pose: SE2) -> str:
    return f"({round(pose.x, 3) + 0.0:g}, {round(pose.y, 3) + 0.0:g})"


def _key(sensor: SensorSettings) -> tuple[str, str, str]:
    """Return what of a sensor stays whatever its topics and frames are called."""
    return type(sensor).__name__, sensor.site, sensor.name
