"""Actions that start a world and put models into it."""

from __future__ import annotations

from launch.frontend import expose_action
from launch_ros.actions import IncludeOfPackage

__all__ = ["GzServer", "GzSpawnModel"]


@expose_action("gz_server")
class GzServer(IncludeOfPackage):
    """Simulates a world: `world_sdf_file`."""

    file = "ros_gz_sim", "gz_server.launch.py"


@expose_action("gz_spawn_model")
class GzSpawnModel(IncludeOfPackage):
    """Puts a model into the world: by `file`, `model_string` or `topic`, at `x`, `y`, `z`, `Y`."""

    file = "ros_gz_sim", "gz_spawn_model.launch.py"
