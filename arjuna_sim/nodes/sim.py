"""The simulator as a node: a robot's topics, and the services of a simulator."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rosgraph_msgs.msg import Clock
from simulation_interfaces.msg import SimulationState
from std_msgs.msg import Float64

from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_sim.devices.drive import CommandError, Velocity
from arjuna_sim.files.library import Library
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.inputs import named_robot, named_world
from arjuna_sim.model.settings import CameraSettings
from arjuna_sim.nodes.camera import CameraTopics
from arjuna_sim.nodes.contacts import ContactTopic
from arjuna_sim.nodes.robot_topics import RobotTopics
from arjuna_sim.nodes.sensor_topics import SensorTopics
from arjuna_sim.nodes.services.entities import EntityServices
from arjuna_sim.nodes.services.known_entities import KnownEntities
from arjuna_sim.nodes.services.simulation import SimulationServices
from arjuna_sim.nodes.services.spawning import SpawnServices
from arjuna_sim.nodes.services.stepping import StepAction
from arjuna_sim.nodes.services.worlds import WorldServices
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.observation import Observation
from arjuna_sim.physics.pacing import PaceMeter, Pacer
from arjuna_sim.simulator import Simulator

_CHECK_PERIOD = 2.0  # [s] between looks for who publishes the wrong type
_TYPES = {False: "geometry_msgs/msg/Twist", True: "geometry_msgs/msg/TwistStamped"}


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
        quitting: Whether a client asked the process to end.
        interactive: Whether it runs by the wall clock, rather than tick by tick as it is told.
    """

    Config = SimConfig
    DEFAULT_NAME = "sim"
    quitting = False

    def configure(self) -> None:
        """Load robot and world, and create the topics and services."""
        config: SimConfig = self.config
        start = config.initial_pose
        self.simulator = Simulator(
            named_robot(config.robot, config.robot_arguments),
            named_world(config.world),
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
        self.interactive = False
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)
        self._meter, self._ticks = PaceMeter(), 0
        self._create_topics()
        self._create_services()

    def _create_topics(self) -> None:
        """Create publishers in the order of publication, and the command's subscription."""
        self._clock_out = self.publisher(Clock, "/clock", qos.LATEST)
        robot = self.simulator.robot
        self._robot = RobotTopics(self, robot)
        sensors = self._robot.settings.sensors
        cameras = [s for s in sensors if isinstance(s, CameraSettings)]
        self._cameras = [CameraTopics(self, self.simulator, camera) for camera in cameras]
        self._further = SensorTopics(self, self.simulator, self._robot.settings.further)
        self.contacts = ContactTopic(self, robot.urdf.name)
        self._pace_out = self.publisher(Float64, "real_time_factor", qos.DEFAULT)
        topic = self._robot.drive.command_topic
        self._stamped = self.config.enable_stamped_cmd_vel or self._robot.drive.stamped
        if self._stamped:
            self.subscribe(TwistStamped, topic, lambda msg: self._on_twist(msg.twist), qos.LATEST)
        else:
            self.subscribe(Twist, topic, self._on_twist, qos.LATEST)
        self.every(_CHECK_PERIOD, self._check_command_type)

    def _create_services(self) -> None:
        """Create the services and the action of simulation_interfaces."""
        known = KnownEntities(self.simulator)
        self._steps = StepAction(self, lambda: self.state)
        SimulationServices(self, self._steps, known.infos.clear)
        EntityServices(self, known)
        SpawnServices(self, known)
        WorldServices(self, known.infos.clear)

    def activate(self) -> None:
        """Begin pacing anew, and say where the world is."""
        if self.config.publish_ground_truth:
            self._robot.publish_static(self.simulator.time)
        self._pacer.restart()
        self._meter.pause()

    def deactivate(self) -> None:
        """End what clients wait for, and say how fast it was."""
        self._steps.abort_all()
        for camera in self._cameras:
            camera.close()
        self.simulator.close()
        if self._meter.summary is not None:
            self.get_logger().info(self._meter.summary)

    @property
    def paused(self) -> bool:
        """Whether simulated time stands still."""
        return bool(self.state != SimulationState.STATE_PLAYING)

    @property
    def _is_stepping(self) -> bool:
        """Whether the action simulate_steps wants the next tick."""
        return self._steps.goal is not None

    def cleanup(self) -> None:
        """Drop the simulation."""
        self.last = None
        del self.simulator

    def on_config(self, config: Any) -> None:
        """Take a new real-time factor, new limits of the drive and noises of the odometry."""
        self._pacer = Pacer(config.real_time_factor, lambda: self._wall)
        if hasattr(self, "simulator"):
            self.simulator.adjust(config)

    def tick(self) -> None:
        """Advance one tick, unless inactive or paused, and publish what it brought."""
        if self.active and (not self.paused or self._is_stepping):
            self.advance()
            self._steps.count()

    def advance(self) -> None:
        """Advance one tick and publish what it brought: time first, transforms before sensors."""
        observation = self.simulator.step(self._command)
        self._command = None
        self._ticks += 1
        self.last = observation
        now = observation.time
        self._clock_out.publish(Clock(clock=time_msg(now)))
        self._robot.publish(observation)
        self._further.publish(now)
        for camera in self._cameras:
            camera.publish(now, self.interactive)
        self.contacts.update(observation.contacts, now)

    def begin_anew(self) -> None:
        """Count contacts from zero, and publish the time, which was set back."""
        self.contacts.log.reset()
        self.tell_time()

    def tell_time(self) -> None:
        """Publish the time now, where it was set back."""
        self._clock_out.publish(Clock(clock=time_msg(self.simulator.time)))

    def realtime_due(self, wall_now: float) -> float:
        """Tell how long it is until the next tick is due.

        Args:
            wall_now: Real time on any steady clock [s].

        Returns:
            Real time to wait [s]; 0 or less means now, inf that no tick will come of itself.
        """
        self.interactive = True
        if not self.active or self.paused:
            self._pacer.restart()
            self._meter.pause()
            return 0.0 if self.active and self._is_stepping else math.inf
        self._wall = wall_now
        factor = self._meter.update(wall_now, self._ticks * self.config.tick)
        if factor is not None:
            self._pace_out.publish(Float64(data=factor))
        return self._pacer.wait(self.simulator.time)

    def _on_twist(self, message: Any) -> None:
        try:
            self._command = Velocity(message.linear.x, message.angular.z, message.linear.y)
        except CommandError as error:
            self.get_logger().warning(f"{self._robot.drive.command_topic} ignored: {error}")

    def _check_command_type(self) -> None:
        """Warn once where someone publishes the type that is not listened to."""
        listened = _TYPES[self._stamped]
        topic = self._robot.drive.command_topic
        for info in self.get_publishers_info_by_topic(self.process.absolute(topic)):
            if info.topic_type != listened and not self._warned:
                self._warned = True
                self.get_logger().warning(
                    f"'{info.node_name}' publishes {topic} as {info.topic_type}, but {listened} is"
                    " listened to; the parameter enable_stamped_cmd_vel chooses"
                )
