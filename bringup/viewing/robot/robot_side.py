"""The viewer's ROS node: what it hears while somebody looks, and what it says for them."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import header, planar_covariance, pose_msg, seconds
from arjuna_core.se2 import SE2
from bringup.viewing.drawing import wishes
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.robot.driving import HandDrive
from bringup.viewing.robot.entities import EntityWatch, pose3
from bringup.viewing.robot.managed import ManagedNodes
from bringup.viewing.robot.navigation import NavigationWatch
from bringup.viewing.robot.services import Services
from bringup.viewing.robot.topics import Feed

_BELIEF = np.diag([0.25, 0.25, 0.0685])  # what RViz's pose estimate says
_SETTLE = 20  # turns of the executor until what was closed is gone
_TURN = 0.001
_SLOW, _RARE = 0.25, 2.0  # [s, wall]


@dataclass(frozen=True)
class RobotOptions:
    """Where the robot is found.

    Attributes:
        namespace: Of its topics and services.
        fixed_frame: The frame to draw and to command in.
        command_topic: Of velocities by hand.
        topics: Other names of topics, by the keys of `TOPICS`.
    """

    namespace: str = ""
    fixed_frame: str = "map"
    command_topic: str = "cmd_vel"
    topics: Mapping[str, str] = field(default_factory=dict)


class RobotSide:
    """Listens to layers, acts on wishes; everything happens in `spin` and `tick`.

    Args:
        options: Where the robot is found.
        context: An rclpy context to live in; its own if None.
    """

    def __init__(self, options: RobotOptions, context: Context | None = None) -> None:
        self._owned = context is None
        self._context = context or new_context()
        self.node = Node(
            *("viewer",),
            context=self._context,
            namespace=options.namespace,
            start_parameter_services=False,
        )
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        services = Services(self.node)
        self.frames = Frames(options.fixed_frame)
        self.navigation = NavigationWatch(self.node, services)
        self.managed = ManagedNodes(services)
        self.entities = EntityWatch(services)
        self._feed = Feed(self.node, options.topics)
        self._hand = HandDrive(self.node, options.command_topic)
        self._pose_out = self.node.create_publisher(
            PoseWithCovarianceStamped, "initialpose", qos.DEFAULT
        )
        self._point_out = self.node.create_publisher(PointStamped, "clicked_point", qos.DEFAULT)
        self._layers: Collection[str] = ()
        self._transforms: list[Any] = []
        self._slow_due = self._rare_due = 0.0

    def listen(self, layers: Collection[str]) -> None:
        """Hear what belongs to layers, and the transforms; with no layers, nothing at all."""
        self._layers = frozenset(layers)
        self._feed.listen(self._layers)
        self.navigation.listen(bool(layers))
        if layers and not self._transforms:
            self._listen_to_transforms()
        elif not layers:
            self._hand.halt()
            while self._transforms:
                self.node.destroy_subscription(self._transforms.pop())
            for _ in range(_SETTLE):
                self._executor.spin_once(timeout_sec=0.0)

    def _listen_to_transforms(self) -> None:
        for topic, profile, static in (
            ("tf", qos.TF, False),
            ("tf_static", qos.TF_STATIC_SUBSCRIPTION, True),
        ):
            subscription = self.node.create_subscription(
                TFMessage, topic, lambda m, static=static: self._on_transforms(m, static), profile
            )
            self._transforms.append(subscription)

    def _on_transforms(self, message: Any, static: bool) -> None:
        for item in message.transforms:
            self.frames.insert(
                item.header.frame_id.lstrip("/"),
                item.child_frame_id.lstrip("/"),
                seconds(item.header.stamp),
                pose3(item.transform),
                static,
            )

    def spin(self, until: float) -> None:
        """Take in what comes until a time [s, monotonic], and in any case all that waits now."""
        while (left := until - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
        reached: list[bool] = []
        self._executor.create_task(lambda: reached.append(True))  # the queue is first in, first out
        while not reached:
            self._executor.spin_once(timeout_sec=_TURN)

    def tick(self, now: float) -> None:
        """Publish and ask what is due at a time [s, monotonic]."""
        self._hand.tick(now)
        if now >= self._slow_due:
            self._slow_due = now + _SLOW
            self.managed.ask_next()
            if "people" in self._layers:
                self.entities.ask()
        if now >= self._rare_due:
            self._rare_due = now + _RARE
            self._feed.listen(self._layers)

    def take(self) -> Iterator[tuple[str, Any]]:
        """Yield what came on the topics, as `Feed.take` does."""
        return self._feed.take()

    def act(self, wish: wishes.Wish, now: float) -> None:
        """Do what a person asks for at a time [s, monotonic]."""
        frame = self.frames.fixed or "map"
        if isinstance(wish, wishes.Goal):
            self.navigation.send(wish.pose, frame)
        elif isinstance(wish, wishes.PoseEstimate):
            self._estimate(wish.pose, frame)
        elif isinstance(wish, wishes.GroundPoint):
            message = PointStamped(header=header(frame, 0.0))
            message.point.x, message.point.y = wish.x, wish.y
            self._point_out.publish(message)
        elif isinstance(wish, wishes.Drive):
            self._hand.drive(wish.speed, wish.turn_rate, now)
        elif isinstance(wish, wishes.Stop):
            self.navigation.cancel()
            self._hand.stop()
        elif isinstance(wish, wishes.Manage):
            self.managed.command(wish.command)
        elif isinstance(wish, wishes.ClearCostmaps):
            self.managed.clear_costmaps()

    def _estimate(self, pose: SE2, frame: str) -> None:
        message = PoseWithCovarianceStamped(header=header(frame, 0.0))
        message.pose.pose = pose_msg(pose)
        message.pose.covariance = planar_covariance(_BELIEF)
        self._pose_out.publish(message)

    def close(self) -> None:
        """Leave the graph."""
        self.listen(())
        self.node.destroy_node()
        self._executor.shutdown()
        if self._owned:
            self._context.shutdown()
