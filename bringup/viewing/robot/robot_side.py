"""The viewer's ROS node: it listens while somebody looks, and speaks for them."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, PoseStamped, PoseWithCovarianceStamped
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import header, planar_covariance, pose_msg, pose_stamped
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from bringup.viewing.displays.base import Display
from bringup.viewing.displays.robot import People
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.robot.entities import EntityWatch
from bringup.viewing.robot.joints import JointSliders
from bringup.viewing.robot.managed import ManagedNodes
from bringup.viewing.robot.navigation import NavigationWatch
from bringup.viewing.robot.services import Services
from bringup.viewing.robot.topics import Feed

_TOOLS: dict[str, tuple[Any, str]] = {
    "SetInitialPose": (PoseWithCovarianceStamped, "initialpose"),
    "SetGoal": (PoseStamped, "goal_pose"),
    "PublishPoint": (PointStamped, "clicked_point"),
}
"""RViz's tools, what they publish and on which topic where nothing else is said."""
_COVARIANCE = np.diag([0.25, 0.25, 0.0685])  # of RViz's pose estimate


class RobotSide:
    """Listens to displays' topics and publishes commands; all happens in `spin` and `tick`.

    Args:
        fixed_frame: The frame to draw and to command in.
        command_topic: Of velocities by hand.
    """

    def __init__(
        self,
        context: Context | None = None,
        namespace: str = "",
        fixed_frame: str = "map",
        command_topic: str = "cmd_vel",
    ) -> None:
        self._owned = context is None
        self._context = context or new_context()
        self.node = Node(
            "viewer", context=self._context, namespace=namespace, start_parameter_services=False
        )
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        services = Services(self.node)
        self.frames = Frames(fixed_frame)
        self.navigation = NavigationWatch(self.node, services)
        self.managed = ManagedNodes(services)
        self.entities = EntityWatch(services)
        self.feed = Feed(self.node, services)
        self.joints = JointSliders(self.node)
        self._hand = HandDrive(self.node, command_topic)
        self._outs: dict[str, Any] = {}
        self.command_on({})
        self._displays: Mapping[str, Display] = {}
        self._transforms: list[Any] = []
        self._questions_due = self._topics_due = 0.0

    def command_on(self, topics: Mapping[str, str]) -> None:
        """Publish what tools command on other topics than the usual ones, by the tools' names.

        The usual ones are in the viewer's namespace, also where a file has them with a slash.
        """
        for tool, (kind, usual) in _TOOLS.items():
            topic = topics.get(tool, usual)
            if topic.lstrip("/") == usual or not self.feed.is_name(topic):
                topic = usual
            out = self._outs.get(tool)
            if out is not None and out.topic_name == self.node.resolve_topic_name(topic):
                continue  # who listens knows it already
            if out is not None:
                self.node.destroy_publisher(out)
            self._outs[tool] = self.node.create_publisher(kind, topic, qos.DEFAULT)

    def listen(self, displays: Mapping[str, Display] | None) -> None:
        """Subscribe to the topics of displays, by their keys, and to transforms; None: to none."""
        self._displays = displays or {}
        self.feed.listen(self._displays)
        self.navigation.listen(displays is not None)
        if displays is not None and not self._transforms:
            for topic, profile in (("tf", qos.TF), ("tf_static", qos.TF_STATIC_SUBSCRIPTION)):
                static = topic == "tf_static"
                subscription = self.node.create_subscription(
                    *(TFMessage, topic),
                    lambda m, static=static: self.frames.take(m, static),
                    profile,
                )
                self._transforms.append(subscription)
        elif displays is None:
            self._hand.halt()
            while self._transforms:
                self.node.destroy_subscription(self._transforms.pop())
            for _ in range(20):  # until what was closed is gone
                self._executor.spin_once(timeout_sec=0.0)

    def spin(self, until: float) -> None:
        """Take in what comes until a time [s, monotonic], and in any case all that waits now."""
        while (remaining := until - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=remaining)
        reached: list[bool] = []
        self._executor.create_task(lambda: reached.append(True))  # the queue is first in, first out
        while not reached:
            self._executor.spin_once(timeout_sec=0.001)

    def tick(self, now: float) -> None:
        """Publish and ask what is due at a time [s, monotonic]."""
        self._hand.tick(now)
        if now >= self._questions_due:
            self._questions_due = now + 0.25
            self.managed.ask_next()
            if any(isinstance(display, People) for display in self._displays.values()):
                self.entities.ask()
        if now >= self._topics_due:
            self._topics_due = now + 2.0
            self.feed.listen(self._displays)

    def topics(self) -> dict[str, str]:
        """Return the type of each topic that somebody else publishes."""
        node = self.node
        own = {publisher.topic_name for publisher in node.publishers}
        found = node.get_topic_names_and_types()
        return {
            name: types[0] for name, types in found if node.count_publishers(name) > (name in own)
        }

    @property
    def _frame(self) -> str:
        return self.frames.fixed or "map"

    def send_goal(self, pose: SE2) -> None:
        """Ask the navigator to drive to a pose in the fixed frame.

        Where another node listens to /goal_pose it is published there, as RViz does; navigators
        take it from there too. On a topic that a file of RViz names it is published in any case.
        """
        out = self._outs["SetGoal"]
        infos = self.node.get_subscriptions_info_by_topic(out.topic_name)
        names = {info.node_name for info in infos} - {self.node.get_name()}
        usual = self.node.resolve_topic_name(_TOOLS["SetGoal"][1])
        if out.topic_name != usual or names - {"bt_navigator"}:
            out.publish(pose_stamped(pose, self._frame, 0.0))
            self.navigation.published(out.topic_name, names)
        else:
            self.navigation.send([pose], self._frame)

    def estimate(self, pose: SE2) -> None:
        """Publish a person's estimate of the robot's pose in the fixed frame."""
        message = PoseWithCovarianceStamped(header=header(self._frame, 0.0))
        message.pose.pose = pose_msg(pose)
        message.pose.covariance = planar_covariance(_COVARIANCE)
        self._outs["SetInitialPose"].publish(message)

    def publish_point(self, pose: SE2) -> None:
        """Publish a point of the fixed frame."""
        message = PointStamped(header=header(self._frame, 0.0))
        message.point.x, message.point.y = pose.x, pose.y
        self._outs["PublishPoint"].publish(message)

    def drive(self, speed: float, turn_rate: float) -> None:
        """Drive by hand for a moment [m/s, rad/s]."""
        self._hand.drive(speed, turn_rate, time.monotonic())

    def stop(self) -> None:
        """Cancel all goals and stand still."""
        self.navigation.cancel()
        self._hand.stop()

    def close(self) -> None:
        """Leave the graph."""
        self.listen(None)
        self.node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()


class HandDrive:
    """Publishes velocities; the topic is advertised when it is first used.

    Args:
        hold: How long one request to drive holds; a button that is held renews it [s, wall].
        stops: Stops that are sent, for a lost one must not leave the robot driving.
    """

    def __init__(self, node: Node, topic: str, hold: float = 0.35, stops: int = 5) -> None:
        self._node = node
        self._topic = topic
        self._hold, self._stops = hold, stops
        self._output: VelocityOutput | None = None
        self._until = 0.0
        self._velocity = STILL
        self._stops_left = 0

    def drive(self, speed: float, turn_rate: float, now: float) -> None:
        """Drive [m/s, rad/s] from a time [s, monotonic] on, for a moment."""
        self._velocity, self._until = Velocity(speed, yaw_rate=turn_rate), now + self._hold
        self._stops_left = self._stops

    def stop(self) -> None:
        """Stand still from now on."""
        self._until, self._stops_left = 0.0, self._stops

    def tick(self, now: float) -> None:
        """Publish what is due at a time [s, monotonic]; called 10 times a second."""
        if now < self._until:
            self._publish(self._velocity)
        elif self._stops_left > 0:
            self._stops_left -= 1
            self._publish(STILL)

    def halt(self) -> None:
        """Publish the stop that is due at once, before nobody ticks any more."""
        if self._stops_left > 0:
            self._stops_left = 0
            self._until = 0.0
            self._publish(STILL)

    def _publish(self, velocity: Velocity) -> None:
        if self._output is None:
            self._output = VelocityOutput(self._node, None, frame="", topic=self._topic)
        self._output.publish(velocity)
