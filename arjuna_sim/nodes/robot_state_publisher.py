"""robot_state_publisher: the robot's description and the transforms of its joints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from arjuna_core.config import fixed, param
from arjuna_core.errors import ConfigError, RobotError
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, transform3_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformPublisher, transforms_msg
from arjuna_core.timing import Periodic
from arjuna_sim.inputs import described, named_robot
from arjuna_sim.model.optical import sensor_frame
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Urdf


@dataclass(frozen=True)
class RobotStatePublisherConfig:
    """Parameters of the node `robot_state_publisher`."""

    robot: str = param(
        "", "The robot's URDF, xacro or SDF file; empty takes the shipped one.", path=True
    )
    robot_arguments: str = fixed(
        "", "Arguments of the robot's xacro file, each name:=value, as in a shell."
    )
    robot_description: str = param(
        "", "The text of a URDF or SDF, in place of a file; a new one is published at once."
    )
    frame_prefix: str = param("", "What stands before the links' names in transforms.")
    ignore_timestamp: bool = param(
        False, "Whether joint states older than those before are published, too."
    )
    publish_frequency: float = param(
        20.0, "Greatest rate of moving joints' transforms.", unit="Hz", minimum=0.1, maximum=1000.0
    )


class RobotStatePublisherNode(ManagedNode):
    """Publishes /robot_description, /tf_static and, from /joint_states, /tf.

    Attributes:
        given: The robot, where it is not to be read from the parameters' file.
    """

    Config = RobotStatePublisherConfig
    DEFAULT_NAME = "robot_state_publisher"
    given: RobotModel | None = None

    def configure(self) -> None:
        """Load the robot and create the topics."""
        self._load(self.config)
        self._description = self.publisher(String, "robot_description", qos.LATCHED)
        self._static = TransformPublisher(self, "/tf_static", qos.TF_STATIC)
        self._moving = TransformPublisher(self, "/tf", qos.TF)
        self._due = Periodic(1.0 / self.config.publish_frequency)
        self.subscribe(JointState, "joint_states", self._on_joints, qos.DEFAULT)

    def _load(self, config: RobotStatePublisherConfig) -> None:
        self._sensors: list[SensorSettings] = []
        self._shown = config.robot_description, config.frame_prefix
        self._newest = -math.inf
        if config.robot_description:
            self._urdf: Urdf = described(config.robot_description)
        else:
            robot = self.given or named_robot(config.robot, config.robot_arguments)
            self._urdf, self._sensors = robot.urdf, list(robot.settings.sensors)

    def activate(self) -> None:
        """Publish what never changes, all fixed joints in one message."""
        self._description.publish(String(data=self._urdf.text))
        fixed = [
            self._transform(joint.T_parent_child, joint.parent, joint.child, self.now)
            for joint in self._urdf.joints.values()
            if joint.kind == "fixed"
        ]
        self._static.publish(transforms_msg(*fixed, *self._of_sensors()))

    def _of_sensors(self) -> list[TransformStamped]:
        """Return the transforms of sensors' frames that are no links, such as optical ones."""
        frames = (sensor_frame(self._urdf, s) for s in self._sensors)
        return [
            self._transform(frame.T_parent, frame.parent, frame.name, self.now)
            for frame in {frame.name: frame for frame in frames}.values()
            if frame.parent is not None
        ]

    def _transform(self, T: Pose3, parent: str, child: str, now: float) -> TransformStamped:
        prefix = self.config.frame_prefix
        return transform3_msg(T, f"{prefix}{parent}", f"{prefix}{child}", now)

    def on_config(self, config: Any) -> None:
        """Take a new rate, prefix or description.

        Raises:
            ConfigError: The description is none.
        """
        self._due = Periodic(1.0 / config.publish_frequency)
        if self._shown == (config.robot_description, config.frame_prefix):
            return
        try:
            self._load(config)
        except RobotError as error:
            raise ConfigError(str(error)) from error
        if self.active:
            self.activate()

    def _on_joints(self, message: Any) -> None:
        now = seconds(message.header.stamp)
        if now < self._newest and not self.config.ignore_timestamp:
            return
        self._newest = now
        if not self._due.due(now):
            return
        positions = dict(zip(message.name, message.position, strict=False))
        moving = []
        for name, joint in self._urdf.joints.items():
            follows = joint.mimic
            if name not in positions and follows is not None and follows.joint in positions:
                positions[name] = follows.multiplier * positions[follows.joint] + follows.offset
            if name in positions and joint.has_position:
                pose = joint.at(positions[name])
                moving.append(self._transform(pose, joint.parent, joint.child, now))
        self._moving.publish(transforms_msg(*moving))

    def on_time_jump(self) -> None:
        """Take joint states of the time before."""
        self._newest = -math.inf
