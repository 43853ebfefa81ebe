"""The nodes of one robot among several, below a namespace of its own."""

from __future__ import annotations

from dataclasses import dataclass

from rclpy.lifecycle import TransitionCallbackReturn
from rosgraph_msgs.msg import Clock

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.process import Process
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.nodes.ekf import EkfNode
from arjuna_sim.nodes.robot_interface import RobotInterface
from arjuna_sim.nodes.robot_state_publisher import RobotStatePublisherNode
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.physics.stage import Stage


class RobotStartError(ArjunaError):
    """A robot's nodes could not be brought up."""


@dataclass(frozen=True)
class RobotConfig:
    """Parameters of the node `simulated_robot`: none, for they are those of `sim`."""


class SimulatedRobotNode(ManagedNode):
    """One robot's topics, and the time; the simulator's node ticks it."""

    Config = RobotConfig
    DEFAULT_NAME = "simulated_robot"
    robot: DrivenRobot
    stage: Stage
    simulated: SimConfig

    def configure(self) -> None:
        """Create the topics."""
        self._clock_out = self.publisher(Clock, "/clock", qos.LATEST)
        self.interface = RobotInterface(self, self.robot, self.stage, self.simulated)

    def activate(self) -> None:
        """Say where the world is."""
        self.interface.begin(self.now)

    def deactivate(self) -> None:
        """End drawing pictures."""
        self.interface.close()

    def tell_time(self, now: float) -> None:
        """Publish the time [s]."""
        self._clock_out.publish(Clock(clock=time_msg(now)))


class RobotNodes:
    """A robot's own topics, its description and, where it is wanted, its filter of odometry.

    Args:
        beside: The process of the simulator's node.
        namespace: The robot's.
        robot: The robot.
        stage: What it stands on.
        config: The simulator's parameters.

    Attributes:
        namespace: The robot's.
        robot: The robot.

    Raises:
        RobotStartError: They could not be configured; nothing is left of them.
    """

    def __init__(
        self, beside: Process, namespace: str, robot: DrivenRobot, stage: Stage, config: SimConfig
    ) -> None:
        self.namespace, self.robot = namespace, robot
        self._process = Process("robot", True, namespace=namespace, beside=beside)
        self._node = SimulatedRobotNode(self._process)
        self._node.robot, self._node.stage, self._node.simulated = robot, stage, config
        described = RobotStatePublisherNode(self._process)
        described.given = robot.model
        self._nodes: list[ManagedNode] = [self._node, described]
        self._run("configure", self._nodes)
        topics = self.interface.topics
        imu = topics.settings.first(ImuSettings)
        if topics.is_fused and imu is not None:
            self._nodes.append(EkfNode(self._process, {"imu0": imu.topic}))
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

    def tell_time(self, now: float) -> None:
        """Publish the time [s] in the robot's namespace."""
        self._node.tell_time(now)

    def destroy(self) -> None:
        """Take the nodes and their topics out of the graph."""
        for node in reversed(self._nodes):
            node.trigger_shutdown()
        self._process.close()
