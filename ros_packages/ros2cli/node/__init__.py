"""The node of a command."""

NODE_NAME_PREFIX = "_ros2cli"
