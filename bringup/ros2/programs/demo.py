"""`ros2 run demo_nodes_cpp talker`, `listener`: whether anything arrives at all."""

from __future__ import annotations

from std_msgs.msg import String

from bringup.ros2.client import Client

_PERIOD, _DEPTH = 1.0, 10  # [s], as the original's


def talk(words: list[str]) -> None:
    """Publish a greeting each second."""
    with Client(name="talker") as client:
        node = client.node
        publisher = node.create_publisher(String, "chatter", _DEPTH)
        count = 0

        def say() -> None:
            nonlocal count
            count += 1
            message = String(data=f"Hello World: {count}")
            node.get_logger().info(f"Publishing: '{message.data}'")
            publisher.publish(message)

        node.create_timer(_PERIOD, say)
        client.pause()


def listen(words: list[str]) -> None:
    """Print the greetings."""
    with Client(name="listener") as client:
        node = client.node

        def heard(message: String) -> None:
            node.get_logger().info(f"I heard: [{message.data}]")

        node.create_subscription(String, "chatter", heard, _DEPTH)
        client.pause()
