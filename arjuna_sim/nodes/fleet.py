"""The robots of a simulation that have nodes of their own, as they come and go."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

from rclpy.lifecycle import TransitionCallbackReturn
from rosgraph_msgs.msg import Clock

from arjuna_core.config import fixed
from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.process import Process
from arjuna_core.se2 import SE2
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.inputs import named_robot
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.nodes.ekf import EkfNode
from arjuna_sim.nodes.robot_interface import RobotInterface
from arjuna_sim.nodes.robot_state_publisher import RobotStatePublisherNode
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.physics.stage import Stage
from arjuna_sim.simulation import Simulation, Start


class RobotStartError(ArjunaError):
    """A robot's nodes could not be brought up."""


@dataclass(frozen=True)
class SimulatedRobotConfig:
    """Parameters of the node `simulated_robot`."""

    robot: str = fixed("", "The robot's file, for who drives it.")


class SimulatedRobotNode(ManagedNode):
    """One robot's topics, and the time; the simulator's node has its parameters, and ticks it."""

    Config = SimulatedRobotConfig
    DEFAULT_NAME = "simulated_robot"
    robot: DrivenRobot
    stage: Stage
    simulated: SimConfig

    def configure(self) -> None:
        """Create the topics."""
        self._clock_out = self.publisher(Clock, "/clock", qos.LATEST)
        self.interface = RobotInterface(self, self.robot, self.stage, self.simulated)

    def activate(self) -> None:
        """Publish the pose of the world."""
        self.interface.begin(self.now)

    def deactivate(self) -> None:
        """End drawing pictures."""
        self.interface.close()

    def publish_time(self, now: float) -> None:
        """Publish the time [s]."""
        self._clock_out.publish(Clock(clock=time_msg(now)))


class RobotNodes:
    """A robot's own topics, its description and, where it is wanted, its filter of odometry.

    A launch file's robot_state_publisher describes it where the configuration says so, or where it
    is seen: at the start of a process nothing may have been seen yet.

    Raises:
        RobotStartError: They could not be configured; nothing is left of them.
    """

    def __init__(
        self, beside: Process, namespace: str, robot: DrivenRobot, stage: Stage, config: SimConfig
    ) -> None:
        self.namespace, self.robot = namespace, robot
        self._process = Process("robot", True, namespace=namespace, beside=beside)
        self._node = SimulatedRobotNode(self._process, {"robot": str(robot.model.urdf.path)})
        seen = self._node.count_publishers("robot_description") > 0
        is_described = config.frames_of_file or seen
        config = dataclasses.replace(config, frames_of_file=is_described)
        self._node.robot, self._node.stage, self._node.simulated = robot, stage, config
        self._nodes: list[ManagedNode] = [self._node]
        if not is_described:
            described = RobotStatePublisherNode(self._process)
            described.given = robot.model
            self._nodes.append(described)
        self._run("configure", self._nodes)
        topics = self.interface.topics
        imu = topics.settings.first(ImuSettings)
        if topics.is_fused and imu is not None:
            given = {"imu0": imu.topic, "odom_topic": topics.fused_topic}
            self._nodes.append(EkfNode(self._process, given))
            self._run("configure", self._nodes[-1:])

    @property
    def interface(self) -> RobotInterface:
        """The robot's topics."""
        return self._node.interface

    def _run(self, step: str, nodes: list[ManagedNode]) -> None:
        for node in nodes:
            if getattr(node, f"trigger_{step}")() != TransitionCallbackReturn.SUCCESS:
                name = node.get_fully_qualified_name()
                self.destroy()
                raise RobotStartError(f"{name} failed to {step}; see its log above")

    def activate(self) -> None:
        """Let the nodes work.

        Raises:
            RobotStartError: One refuses; nothing is left of them.
        """
        self._run("activate", self._nodes)

    def deactivate(self) -> None:
        """Let the nodes rest."""
        for node in reversed(self._nodes):
            node.trigger_deactivate()

    def publish_time(self, now: float) -> None:
        """Publish the time [s] in the robot's namespace."""
        self._node.publish_time(now)

    def destroy(self) -> None:
        """Take the nodes and their topics out of the graph."""
        for node in reversed(self._nodes):
            node.trigger_shutdown()
        self._process.close()


class NamespaceError(ArjunaError):
    """A robot lacks a namespace, or another has it."""


def starts_of(config: SimConfig) -> dict[str, Start]:
    """Return the robots that a simulator starts with, by namespace, and where each starts.

    Raises:
        RobotError: A robot's file cannot be used.
    """
    files = config.robots or (config.robot,) * len(config.namespaces)
    robots = {file: named_robot(file, config.robot_arguments) for file in files}
    numbers = config.starts
    poses: list[SE2 | None] = [SE2(*numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
    poses = poses or [config.initial_pose.asked] * len(files)
    return {
        name.strip("/"): Start(robots[file], pose)
        for name, file, pose in zip(config.namespaces, files, poses, strict=True)
    }


class Fleet:
    """Brings up the nodes of each robot that is there, and takes down those of one that is not.

    A robot of the start has its namespace for a name. The simulator's own robot, where there is
    one, has no nodes here.

    Raises:
        ArjunaError: A robot's nodes could not be configured.
    """

    def __init__(self, node: ManagedNode, simulation: Simulation) -> None:
        self._node, self._simulation = node, simulation
        self._namespaces: dict[str, str] = {}
        self._nodes: dict[str, RobotNodes] = {}
        node.keep(self)
        self.match()

    def __iter__(self) -> Iterator[tuple[str, RobotNodes]]:
        return iter(self._nodes.items())

    def nodes(self, name: str) -> RobotNodes:
        """Return the nodes of a robot."""
        return self._nodes[name]

    def add(self, name: str, namespace: str, robot: RobotModel, pose: SE2) -> None:
        """Put a robot into the world, with nodes below a namespace.

        Raises:
            NamespaceError: Another robot has the namespace.
            BlockedPoseError: It would stand in something.
            ArjunaError: It cannot be simulated, or its nodes cannot be brought up.
        """
        taken = {nodes.namespace: other for other, nodes in self._nodes.items()}
        if SOLO in self._simulation.robots:
            taken[self._node.process.namespace] = "the simulator's own"
        if namespace in taken:
            problem = f"namespace '/{namespace}' is that of robot '{taken[namespace]}'"
            raise NamespaceError(f"{problem}; give another as entity_namespace")
        self._simulation.add(name, Start(robot, pose))
        self._namespaces[name] = namespace
        try:
            self.match()
        except ArjunaError:
            self._simulation.remove(name)
            raise

    def remove(self, name: str) -> None:
        """Take a robot out of the world, and its topics out of the graph."""
        self._simulation.remove(name)
        self.match()

    def match(self) -> None:
        """Have nodes for just the robots that are there.

        Raises:
            ArjunaError: A robot's nodes could not be brought up.
        """
        robots = self._simulation.robots
        for name in [n for n, nodes in self._nodes.items() if robots.get(n) is not nodes.robot]:
            gone = self._nodes.pop(name)
            gone.deactivate()
            # who asks for it may be answered by one of these nodes' own events, still queued
            self._node.process.executor.create_task(gone.destroy)
        for name in [n for n in robots if n != SOLO and n not in self._nodes]:
            namespace, tick = self._namespaces.get(name, name), self._simulation.config.tick
            config = dataclasses.replace(self._node.config, tick=tick)
            if name in self._namespaces:  # spawned later: another launch file's, or nobody's
                config = dataclasses.replace(config, frames_of_file=False)
            process, stage = self._node.process, self._simulation.stage
            made = RobotNodes(process, namespace, robots[name], stage, config)
            if self._node.active:
                made.activate()
            self._nodes[name] = made

    def activate(self) -> None:
        """Let all work.

        Raises:
            ArjunaError: A node refuses.
        """
        for nodes in self._nodes.values():
            nodes.activate()

    def deactivate(self) -> None:
        """Let all rest."""
        for nodes in self._nodes.values():
            nodes.deactivate()

    def destroy(self) -> None:
        """Take all nodes out of the graph."""
        while self._nodes:
            self._nodes.popitem()[1].destroy()
