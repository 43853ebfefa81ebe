"""`ros2 run tf2_ros buffer_server`: a buffer of transforms that other processes ask."""

from __future__ import annotations

from rclpy.duration import Duration
from tf2_ros import Buffer, BufferServer, TransformListener

from bringup.ros2.client import Client
from bringup.ros2.verbs.forward import ros_arguments


def main(words: list[str]) -> None:
    """Serve the action tf2_buffer_server until interrupted; parameters: buffer_size [s]."""
    size = float(ros_arguments(words).parameters.get("buffer_size", 120.0))
    with Client(name="tf_buffer") as client:
        buffer = Buffer(Duration(seconds=size), node=client.node)
        TransformListener(buffer, client.node)
        BufferServer(buffer, client.node, "tf2_buffer_server")
        client.pause()
