"""Launch descriptions that bring controllers up by the spawner."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

__all__ = [
    "generate_controllers_spawner_launch_description",
    "generate_controllers_spawner_launch_description_from_dict",
    "generate_load_controller_launch_description",
]


def generate_controllers_spawner_launch_description_from_dict(
    controller_info_dict: Mapping[str, Any], extra_spawner_args: Sequence[Any] = ()
) -> LaunchDescription:
    """Return what spawns controllers, in this order.

    Its arguments are `controller_manager_name` and `unload_on_kill`.

    Args:
        controller_info_dict: By controller a file of parameters, several or None.
        extra_spawner_args: More arguments of the spawner.

    Raises:
        ValueError: The controllers are no dictionary.
    """
    if not isinstance(controller_info_dict, Mapping):
        raise ValueError(
            "Invalid controller_info_dict type parsed: a dict of controllers is needed,"
            f" not {controller_info_dict!r}"
        )
    files = (f if isinstance(f, list) else [f] for f in controller_info_dict.values() if f)
    parameters = [word for group in files for file in group for word in ("--param-file", file)]
    manager = "--controller-manager", LaunchConfiguration("controller_manager_name")
    words = [*controller_info_dict, *manager, *parameters, *extra_spawner_args]
    unloads = LaunchConfiguration("unload_on_kill")
    spawners = [
        Node(
            package="controller_manager",
            executable="spawner",
            arguments=[*words, *more],
            condition=condition(unloads),
            output="screen",
        )
        for condition, more in ((UnlessCondition, ()), (IfCondition, ("--unload-on-kill",)))
    ]
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "controller_manager_name",
                default_value="controller_manager",
                description="Controller manager node name",
            ),
            DeclareLaunchArgument(
                "unload_on_kill",
                default_value="false",
                description="Wait until the node is interrupted and then unload controller",
            ),
            *spawners,
        ]
    )


def generate_controllers_spawner_launch_description(
    controller_names: Sequence[str],
    controller_params_files: Sequence[Any] | None = None,
    extra_spawner_args: Sequence[Any] = (),
) -> LaunchDescription:
    """Return what spawns controllers, all of the same files of parameters."""
    files = list(controller_params_files or ())
    first = dict.fromkeys(controller_names)
    return generate_controllers_spawner_launch_description_from_dict(
        {name: files if i == 0 else None for i, name in enumerate(first)}, extra_spawner_args
    )


def generate_load_controller_launch_description(
    controller_name: str,
    controller_params_file: Any = None,
    extra_spawner_args: Sequence[Any] = (),
) -> LaunchDescription:
    """Return what spawns one controller, of a file of parameters or several."""
    return generate_controllers_spawner_launch_description_from_dict(
        {controller_name: controller_params_file}, extra_spawner_args
    )
