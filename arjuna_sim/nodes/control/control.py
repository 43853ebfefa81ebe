"""All that commands a robot's joints from outside: topics, actions and controller_manager."""

from __future__ import annotations

from typing import Protocol

from std_msgs.msg import Float64, Float64MultiArray

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.driven_robot import DrivenRobot, Observation
from arjuna_sim.model.joints import ControllerKind, ControllerSettings
from arjuna_sim.nodes.control.grippers import GripperTopics
from arjuna_sim.nodes.control.manager import ControllerManager
from arjuna_sim.nodes.control.trajectories import TrajectoryTopics
from arjuna_sim.physics.robot_motion import JointStates


class _Reporting(Protocol):
    def publish(self, joints: JointStates, now: float) -> None:
        """Report the joints after a tick."""


def _forward(node: ManagedNode, robot: DrivenRobot, settings: ControllerSettings) -> None:
    """Take the values of a controller: all in one message, or one of Gazebo's plug-ins for all."""

    def command(values: list[float]) -> None:
        try:
            robot.controllers.command(settings.name, values)
        except ArjunaError as error:
            node.get_logger().warning(f"command ignored: {error}")

    if settings.is_managed:
        topic = f"{settings.name}/commands"
        node.subscribe(
            Float64MultiArray, topic, lambda message: command(list(message.data)), qos.LATEST
        )
    else:
        topic = settings.topic
        node.subscribe(Float64, topic, lambda message: command([message.data]), qos.LATEST)


class JointControl:
    """The interface of a robot's driven joints; a robot without any has none."""

    def __init__(self, node: ManagedNode, robot: DrivenRobot) -> None:
        self._reporting: list[_Reporting] = []
        controllers = robot.model.settings.controllers
        for settings in controllers:
            if settings.kind is ControllerKind.FORWARD:
                _forward(node, robot, settings)
            elif settings.kind is ControllerKind.TRAJECTORY:
                self._reporting.append(TrajectoryTopics(node, robot, settings))
            elif settings.kind is ControllerKind.GRIPPER and settings.joints:
                self._reporting.append(GripperTopics(node, robot, settings))
        if any(settings.is_managed for settings in controllers):
            ControllerManager(node, robot)

    def publish(self, observation: Observation) -> None:
        """Report the joints after a tick."""
        for each in self._reporting:
            each.publish(observation.joints, observation.time)
