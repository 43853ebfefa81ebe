"""The simulator as a node: a robot's topics, and the services of a simulator."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from simulation_interfaces.msg import SimulationState
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage

from arjuna_core.config import param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import scan_msg, time_msg, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_sim.drive import CommandError, Velocity
from arjuna_sim.library import Library
from arjuna_sim.nodes.camera import CameraTopics
from arjuna_sim.nodes.contacts import ContactTopic
from arjuna_sim.nodes.messages import imu_msg, joint_state_msg, odometry_msg, truth_msg
from arjuna_sim.nodes.services import SimulationServices
from arjuna_sim.observation import Observation
from arjuna_sim.pacing import PaceMeter, Pacer
from arjuna_sim.resources import SearchPath
from arjuna_sim.simulator import Simulator, SimulatorConfig

SHIPPED = Path(__file__).resolve().parents[2]
SHIPPED_ROBOT = SHIPPED / "urdf" / "arjuna.urdf"
SHIPPED_WORLD = SHIPPED / "worlds" / "arjuna_room.world"
ODOM = "odom"
_CHECK_PERIOD = 2.0
_TYPES = {False: "geometry_msgs/msg/Twist", True: "geometry_msgs/msg/TwistStamped"}


@dataclass(frozen=True)
class InitialPose:
    """Where the robot starts in the world."""

    x: float = param(0.0, "Place.", unit="m", read_only=True)
    y: float = param(0.0, "Place.", unit="m", read_only=True)
    yaw: float = param(0.0, "Heading.", unit="rad", read_only=True)


@dataclass(frozen=True)
class SimConfig(SimulatorConfig):
    """Parameters of the node `sim`, over those of the simulator."""

    robot: str = param("", "The robot's .urdf file; empty takes the shipped one.", read_only=True)
    world: str = param("", "The world's SDF file; empty takes the shipped room.", read_only=True)
    seed: int = param(0, "Seed of all chance.", minimum=0, read_only=True)
    real_time_factor: float = param(
        1.0, "Simulated per real time; 0 is as fast as it goes.", minimum=0.0, maximum=1000.0
    )
    enable_stamped_cmd_vel: bool = param(
        False, "Whether cmd_vel is TwistStamped instead of Twist.", read_only=True
    )
    publish_ground_truth: bool = param(
        True, "Whether ground_truth/odom is published.", read_only=True
    )
    resource_folder: str = param(
        ".",
        "Folder that spawn_entity and load_world may read files below, beside the shipped worlds"
        " and robots, packages and models; the working folder if '.'.",
        read_only=True,
    )
    initial_pose: InitialPose = field(default_factory=InitialPose)


class SimNode(ManagedNode):
    """Publishes what the simulated robot senses and takes its commands.

    Whoever runs the process calls `tick`: the lock-step driver, or the interactive host when
    `realtime_due` says so.

    Attributes:
        simulator: The core.
        last: What the last tick brought.
        state: A SimulationState constant: whether simulated time runs.
        library: What clients may name.
        contacts: Counts what the robot touches.
    """

    Config = SimConfig
    DEFAULT_NAME = "sim"

    def configure(self) -> None:
        """Load robot and world, and create the topics and services."""
        config: SimConfig = self.config
        start = config.initial_pose
        self.simulator = Simulator(
            config.robot or SHIPPED_ROBOT,
            config.world or SHIPPED_WORLD,
            config,
            np.random.default_rng(config.seed),
            SE2(start.x, start.y, start.yaw),
        )
        for note in self.simulator.notes:
            self.get_logger().warning(note)
        self.last: Observation | None = None
        self.state = SimulationState.STATE_PLAYING
        self.library = Library(config.resource_folder, SearchPath.of())
        self._command: Velocity | None = None
        self._warned = False
        self._wall = 0.0
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)
        self._meter, self._ticks = PaceMeter(), 0
        self._create_topics()
        self._server = SimulationServices(self)

    def _create_topics(self) -> None:
        """Create publishers in the order of publication, and the command's subscription."""
        self._clock_out = self.publisher(Clock, "/clock", qos.LATEST)
        self._tf_out = self.publisher(TFMessage, "/tf", qos.TF)
        self._odom_out = self.publisher(Odometry, "odom", qos.DEFAULT)
        self._joints_out = self.publisher(JointState, "joint_states", qos.DEFAULT)
        self._imu_out = self.publisher(Imu, "imu/data", qos.SENSOR_PUBLISHER)
        self._scan_out = self.publisher(LaserScan, "scan", qos.SENSOR_PUBLISHER)
        camera = self.simulator.robot.settings.camera
        self._camera = None if camera is None else CameraTopics(self, camera)
        self._truth_out = self.publisher(Odometry, "ground_truth/odom", qos.DEFAULT)
        self.contacts = ContactTopic(self)
        self._pace_out = self.publisher(Float64, "real_time_factor", qos.DEFAULT)
        if self.config.enable_stamped_cmd_vel:
            self.subscribe(
                TwistStamped, "cmd_vel", lambda msg: self._on_twist(msg.twist), qos.LATEST
            )
        else:
            self.subscribe(Twist, "cmd_vel", self._on_twist, qos.LATEST)
        self.every(_CHECK_PERIOD, self._check_command_type)

    def activate(self) -> None:
        """Begin pacing anew."""
        self._pacer.restart()
        self._meter.pause()

    def deactivate(self) -> None:
        """End what clients wait for, and say how fast it was."""
        self._server.abort()
        if self._meter.summary is not None:
            self.get_logger().info(self._meter.summary)

    @property
    def paused(self) -> bool:
        """Whether simulated time stands still."""
        return bool(self.state != SimulationState.STATE_PLAYING)

    def cleanup(self) -> None:
        """Drop the simulation."""
        self.simulator.close()
        self.last = None
        del self.simulator

    def on_config(self, config: Any) -> None:
        """Take a new real-time factor."""
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)

    def tick(self) -> None:
        """Advance one tick, unless inactive or paused, and publish what it brought."""
        if self.active and (not self.paused or self._server.stepping):
            self.advance()
            self._server.after_tick()

    def advance(self) -> None:
        """Advance one tick and publish what it brought: time first, transforms before sensors."""
        observation = self.simulator.step(self._command)
        self._command = None
        self._ticks += 1
        self.last = observation
        now, base = observation.time, self.simulator.robot.urdf.root
        T = transform_msg(observation.odometry.T_odom_base, ODOM, base, now)
        self._clock_out.publish(Clock(clock=time_msg(now)))
        self._tf_out.publish(TFMessage(transforms=[T]))
        self._odom_out.publish(odometry_msg(observation.odometry, ODOM, base, now))
        if self._joints_out.get_subscription_count() > 0:
            self._joints_out.publish(joint_state_msg(observation.joints, now))
        self._publish_sensors(observation)
        if self._camera is not None:
            self._camera.publish(now)
        if self.config.publish_ground_truth and self._truth_out.get_subscription_count() > 0:
            self._truth_out.publish(truth_msg(observation.truth, base, now))
        self.contacts.update(observation.contacts, now)

    def tell_time(self) -> None:
        """Publish the time now, where it was set back."""
        self._clock_out.publish(Clock(clock=time_msg(self.simulator.time)))

    def _publish_sensors(self, observation: Observation) -> None:
        settings = self.simulator.robot.settings
        if observation.imu is not None and self._imu_out.get_subscription_count() > 0:
            assert settings.imu is not None
            self._imu_out.publish(imu_msg(observation.imu, settings.imu.frame, observation.time))
        if observation.scan is not None:
            lidar = settings.lidar
            assert lidar is not None
            self._scan_out.publish(scan_msg(observation.scan, lidar.frame, 1.0 / lidar.rate))

    def realtime_due(self, wall_now: float) -> float:
        """Tell how long it is until the next tick is due.

        Args:
            wall_now: Real time on any steady clock [s].

        Returns:
            Real time to wait [s]; 0 or less means now, inf that no tick will come of itself.
        """
        if not self.active or self.paused:
            self._pacer.restart()
            self._meter.pause()
            return 0.0 if self.active and self._server.stepping else math.inf
        self._wall = wall_now
        factor = self._meter.update(wall_now, self._ticks * self.config.tick)
        if factor is not None:
            self._pace_out.publish(Float64(data=factor))
        return self._pacer.wait(self.simulator.time)

    def _on_twist(self, message: Any) -> None:
        try:
            self._command = Velocity(message.linear.x, message.angular.z)
        except CommandError as error:
            self.get_logger().warning(f"cmd_vel ignored: {error}")

    def _check_command_type(self) -> None:
        """Warn once where someone publishes the type that is not listened to."""
        listened = _TYPES[self.config.enable_stamped_cmd_vel]
        for info in self.get_publishers_info_by_topic("cmd_vel"):
            if info.topic_type != listened and not self._warned:
                self._warned = True
                self.get_logger().warning(
                    f"'{info.node_name}' publishes cmd_vel as {info.topic_type}, but {listened} is"
                    " listened to; the parameter enable_stamped_cmd_vel chooses"
                )
