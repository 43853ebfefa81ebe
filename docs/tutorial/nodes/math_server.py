"""A service's server: adds two numbers for whoever asks."""

from contextlib import suppress
from typing import Any

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class MathServer(Node):
    """Serves add_two_ints."""

    def __init__(self) -> None:
        super().__init__("math_server")
        self.create_service(AddTwoInts, "add_two_ints", self.on_request)
        self.get_logger().info("serving add_two_ints")

    def on_request(self, request: Any, response: Any) -> Any:
        """Answer a request."""
        response.sum = request.a + request.b
        self.get_logger().info(f"{request.a} + {request.b} = {response.sum}")
        return response


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(MathServer())


if __name__ == "__main__":
    main()
