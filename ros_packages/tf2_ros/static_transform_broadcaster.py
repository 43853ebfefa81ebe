"""The broadcaster of transforms that hold at all times."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage


class StaticTransformBroadcaster:
    """Publishes on /tf_static: all of its transforms in one message, for who comes later too."""

    def __init__(self, node: Node, qos: Any = None) -> None:
        latched = qos or QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.pub_tf = node.create_publisher(TFMessage, "/tf_static", latched)
        self.net_message = TFMessage()

    def sendTransform(self, transform: TransformStamped | Iterable[TransformStamped]) -> None:
        """Send a transform, or several; a child frame that was sent before is replaced."""
        new = [transform] if isinstance(transform, TransformStamped) else list(transform)
        children = {one.child_frame_id for one in new}
        kept = [one for one in self.net_message.transforms if one.child_frame_id not in children]
        self.net_message = TFMessage(transforms=[*kept, *new])
        self.pub_tf.publish(self.net_message)
