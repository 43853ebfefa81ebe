"""The action that gives the simulator's topics other names."""

from __future__ import annotations

from launch.frontend import expose_action
from launch_ros.actions import IncludeOfPackage

__all__ = ["RosGzBridge"]


@expose_action("ros_gz_bridge")
class RosGzBridge(IncludeOfPackage):
    """Bridges the topics of a `config_file`."""

    file = "ros_gz_bridge", "ros_gz_bridge.launch.py"
