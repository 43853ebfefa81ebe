"""A lifecycle node: configured, activated and taken down by whoever manages it."""

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn


class Driver(LifecycleNode):
    """Stands for a driver that must not talk before its device is there."""

    def __init__(self) -> None:
        super().__init__("driver")
        self.get_logger().info("unconfigured")

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the device."""
        self.get_logger().info("configured: the device is open")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to publish."""
        self.get_logger().info("active: publishing")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Keep the device, say nothing."""
        self.get_logger().info("inactive")
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close the device."""
        self.get_logger().info("unconfigured: the device is closed")
        return TransitionCallbackReturn.SUCCESS


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Driver())


if __name__ == "__main__":
    main()
