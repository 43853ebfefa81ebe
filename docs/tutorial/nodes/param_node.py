"""Parameters: declared with a default, set by a file or from outside, refused where not valid."""

from contextlib import suppress

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


class ParamNode(Node):
    """Has a speed and a frame."""

    def __init__(self) -> None:
        super().__init__("param_node")
        self.declare_parameter("speed", 0.5)
        self.declare_parameter("frame_id", "base_link")
        self.add_on_set_parameters_callback(self.on_set)
        speed, frame = (self.get_parameter(name).value for name in ("speed", "frame_id"))
        self.get_logger().info(f"Speed: {speed}, Frame: {frame}")

    def on_set(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take values, but no negative speed."""
        for parameter in parameters:
            if parameter.name == "speed" and parameter.value < 0.0:
                return SetParametersResult(successful=False, reason="speed must not be negative")
            self.get_logger().info(f"{parameter.name} is now {parameter.value}")
        return SetParametersResult(successful=True)


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(ParamNode())


if __name__ == "__main__":
    main()
