"""The interface of one robot: topics of its drive and sensors, and its command."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from arjuna_core.ros import qos
from arjuna_core.ros.convert import se2_from_pose
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.velocity import subscribe_velocity
from arjuna_core.twist import Velocity
from arjuna_sim.devices.sensors.battery import BatterySettings
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.driven_robot import DrivenRobot, Observation
from arjuna_sim.nodes.batteries import offer_commands
from arjuna_sim.nodes.camera import CameraTopics
from arjuna_sim.nodes.robot_topics import ContactTopic, RobotTopics
from arjuna_sim.nodes.sensor_topics import SensorTopics
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.physics.stage import Stage


class RobotInterface:
    """Publishes what a simulated robot senses and takes its commands.

    Attributes:
        contacts: Counts what the robot touches.
        topics: Its usual topics.
    """

    def __init__(
        self, node: ManagedNode, robot: DrivenRobot, stage: Stage, config: SimConfig
    ) -> None:
        self._node, self._robot = node, robot
        self._command: Velocity | None = None
        self._truth = config.publish_ground_truth
        self.topics = RobotTopics(node, robot.model, config)
        sensors = self.topics.settings.sensors
        cameras = [s for s in sensors if isinstance(s, CameraSettings)]
        rate = config.cloud_rate
        self._cameras = [CameraTopics(node, robot, stage, camera, rate) for camera in cameras]
        self._further = SensorTopics(node, robot, self.topics.settings.further)
        for battery in (s for s in sensors if isinstance(s, BatterySettings)):
            offer_commands(node, robot, battery)
        self._joints = self._joint_topics() if robot.model.settings.controllers else []
        self.contacts = ContactTopic(node, robot.model.urdf.name)
        self._topic = self.topics.drive.command_topic
        stamped = config.enable_stamped_cmd_vel or self.topics.drive.stamped
        self._commands = subscribe_velocity(node, self._topic, stamped, self._on_command)
        if config.placed_by_estimate:
            node.subscribe(PoseWithCovarianceStamped, "initialpose", self._on_estimate, qos.DEFAULT)

    def begin(self, now: float) -> None:
        """Publish the pose of the world at a time [s]."""
        if self._truth:
            self.topics.publish_static(now)

    def take_command(self) -> Velocity | None:
        """Return the command that came since the last call, if one did."""
        command, self._command = self._command, None
        return command

    def publish(self, observation: Observation, interactive: bool) -> None:
        """Publish a tick's observation, transforms first; `interactive`: drawing takes no time."""
        now = observation.time
        for cut in self._robot.take_cuts():
            self._node.get_logger().warning(f"{self._topic}: {cut}")
        self.topics.publish(observation)
        for each in self._joints:
            each.publish(observation.joints, now)
        self._further.publish(now)
        for camera in self._cameras:
            camera.publish(now, interactive)
        self.contacts.update(observation.contacts, now)

    def close(self) -> None:
        """End drawing beside the physics."""
        for camera in self._cameras:
            camera.close()

    def _rename(self, topic: str, other: str) -> bool:
        """Give a topic of the drive another name; return whether it is one."""
        absolute = self._node.process.absolute
        if absolute(topic) == absolute(self._topic):
            self._topic = other
            self._commands.rename(other)
            return True
        return self.topics.rename_odometry(topic, other)

    def _on_command(self, command: Velocity) -> None:
        self._command = command

    def _on_estimate(self, message: PoseWithCovarianceStamped) -> None:
        """Put the robot where it is said to be."""
        try:
            pose = se2_from_pose(message.pose.pose)
        except ValueError as error:
            self._node.get_logger().warning(f"initialpose: {error}")
            return
        if touched := self._robot.obstacles_at(pose):
            blocking = ", ".join(touched)
            self._node.get_logger().warning(f"initialpose: the pose is blocked by {blocking}")
            return
        self._robot.set_pose(pose)

    def _joint_topics(self) -> list[Any]:
        # Their messages take a quarter of a second to import, which most robots do not need.
        from arjuna_sim.nodes.control.control import joint_topics

        return joint_topics(self._node, self._robot, self._rename)
