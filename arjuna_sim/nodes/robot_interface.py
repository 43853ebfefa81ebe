"""The interface of one robot: topics of its drive and sensors, and its command."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Twist, TwistStamped

from arjuna_core.ros import qos
from arjuna_core.ros.convert import velocity_from_twist
from arjuna_core.ros.node import ManagedNode
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

_TYPES = {False: "geometry_msgs/msg/Twist", True: "geometry_msgs/msg/TwistStamped"}


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
        self._warned = False
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
        self._stamped = config.enable_stamped_cmd_vel or self.topics.drive.stamped
        self._commands = self._listen()
        # [s] between two checks for publishers of the wrong type.
        node.every(2.0, self._check_command_type)

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
            if self._commands is not None:
                self._node.unsubscribe(self._commands)
            self._topic = other
            self._commands = self._listen()
            return True
        return self.topics.rename_odometry(topic, other)

    def _listen(self) -> Any:
        if self._stamped:
            return self._node.subscribe(TwistStamped, self._topic, self._on_stamped, qos.LATEST)
        return self._node.subscribe(Twist, self._topic, self._on_twist, qos.LATEST)

    def _on_stamped(self, message: Any) -> None:
        self._on_twist(message.twist)

    def _on_twist(self, message: Any) -> None:
        command = velocity_from_twist(message)
        if command.is_finite:
            self._command = command
        else:
            self._node.get_logger().warning(f"{self._topic} ignored: {command} must be finite")

    def _check_command_type(self) -> None:
        """Listen to the other type where that alone is published; warn once where both are.

        A participant knows a topic by one type: the old subscription ends a check before the new.
        """
        if self._commands is None:
            self._commands = self._listen()
            return
        node, listened, other = self._node, _TYPES[self._stamped], _TYPES[not self._stamped]
        published = node.get_publishers_info_by_topic(node.process.absolute(self._topic))
        senders = {info.topic_type: info.node_name for info in published}
        if other not in senders:
            return
        if listened not in senders:
            node.unsubscribe(self._commands)
            self._stamped, self._commands = not self._stamped, None
            node.get_logger().info(f"{self._topic}: '{senders[other]}' sends {other}: it is taken")
        elif not self._warned:
            self._warned = True
            node.get_logger().warning(
                f"'{senders[other]}' publishes {self._topic} as {other}, but {listened}, which"
                f" '{senders[listened]}' publishes, is listened to"
            )

    def _joint_topics(self) -> list[Any]:
        # Their messages take a quarter of a second to import, which most robots do not need.
        from arjuna_sim.nodes.control.control import joint_topics

        return joint_topics(self._node, self._robot, self._rename)
