"""Transforms on the topics: what a node's listener takes."""

from __future__ import annotations

import math

from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import transform_msg
from arjuna_core.ros.tf import TransformBuffer, TransformListener
from arjuna_core.se2 import SE2


def test_a_client_s_plain_node_listens_and_refuses_too() -> None:
    context = new_context()
    node = Node("plain", context=context)
    buffer = TransformBuffer()
    listener = TransformListener(node, buffer)
    good, bad = (transform_msg(SE2(), "odom", child, 0.0) for child in ("base", "arm"))
    bad.transform.translation.x = math.nan
    listener._on_moving(TFMessage(transforms=[bad, good]))
    node.destroy_node()
    context.shutdown()
    assert buffer.try_lookup("odom", "base") is not None
    assert buffer.try_lookup("odom", "arm") is None
