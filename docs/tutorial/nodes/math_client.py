"""A service's client: asks once, waits for the answer, ends."""

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.node import Node


def main() -> None:
    """Ask what 3 and 5 make."""
    rclpy.init()
    node = Node("math_client")
    client = node.create_client(AddTwoInts, "add_two_ints")
    while not client.wait_for_service(timeout_sec=1.0):
        node.get_logger().warning("Waiting for server...")
    answer = client.call_async(AddTwoInts.Request(a=3, b=5))
    rclpy.spin_until_future_complete(node, answer)
    node.get_logger().info(f"Result: {answer.result().sum}")


if __name__ == "__main__":
    main()
