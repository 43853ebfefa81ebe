"""The listener that fills a buffer from /tf and /tf_static."""

from __future__ import annotations

import atexit
import contextlib
from threading import Thread
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from tf2_msgs.msg import TFMessage
from tf2_py import TransformException

from tf2_ros.buffer import Buffer

_PATIENCE = 5.0  # [s] for a callback that runs at the end
DEFAULT_TF_TOPIC, DEFAULT_STATIC_TF_TOPIC = "/tf", "/tf_static"


class TransformListener:
    """Feeds a buffer; with `spin_thread` a thread of its own spins the node."""

    def __init__(
        self,
        buffer: Buffer,
        node: Node,
        *,
        spin_thread: bool = False,
        qos: Any = None,
        static_qos: Any = None,
        tf_topic: str = DEFAULT_TF_TOPIC,
        static_tf_topic: str = DEFAULT_STATIC_TF_TOPIC,
    ) -> None:
        moving = qos or QoSProfile(depth=100, history=HistoryPolicy.KEEP_LAST)
        latched = static_qos or QoSProfile(
            depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL, history=HistoryPolicy.KEEP_LAST
        )
        self.buffer, self.node = buffer, node
        self.group = ReentrantCallbackGroup()
        self.tf_sub = node.create_subscription(
            TFMessage, tf_topic, self.callback, moving, callback_group=self.group
        )
        self.tf_static_sub = node.create_subscription(
            TFMessage, static_tf_topic, self.static_callback, latched, callback_group=self.group
        )
        if spin_thread:
            self.executor = SingleThreadedExecutor(context=node.context)
            self.executor.add_node(node)
            thread = Thread(target=_spin, args=(self.executor,), daemon=True)
            self.dedicated_listener_thread = thread
            thread.start()
            atexit.register(_end, self.executor, thread)

    def unregister(self) -> None:
        self.node.destroy_subscription(self.tf_sub)
        self.node.destroy_subscription(self.tf_static_sub)

    def callback(self, data: TFMessage) -> None:
        """Take moving transforms; one that is no transform is named and passed over."""
        self._take(data, self.buffer.set_transform)

    def static_callback(self, data: TFMessage) -> None:
        self._take(data, self.buffer.set_transform_static)

    def _take(self, data: TFMessage, take: Any) -> None:
        for transform in data.transforms:
            try:
                take(transform, "default_authority")
            except TransformException as error:
                self.node.get_logger().warning(f"passed over: {error}", once=True)


def _spin(executor: Executor) -> None:
    """Spin until the executor, or all of ROS, is shut down."""
    with contextlib.suppress(ExternalShutdownException):
        executor.spin()


def _end(executor: Executor, thread: Thread) -> None:
    """End a thread before the interpreter does: within the middleware that aborts the program."""
    executor.shutdown()
    thread.join(_PATIENCE)
