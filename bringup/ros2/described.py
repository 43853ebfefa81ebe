"""Launch files of other packages whose nodes are here: `urdf_launch`, `teleop_twist_joy`."""

from __future__ import annotations

from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

_DEADZONE, _RATE = 0.3, 20.0  # joy's, as that launch file sets them


def robot() -> LaunchDescription:
    """Publish a robot's description and its frames: `urdf_package`, `urdf_package_path`."""
    names = ("urdf_package", "urdf_package_path")
    package, path = (LaunchConfiguration(name) for name in names)
    command = Command(["xacro ", PathJoinSubstitution([FindPackageShare(package), path])])
    text = ParameterValue(command, value_type=str)
    publisher = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{"robot_description": text}],
    )
    return LaunchDescription([*map(DeclareLaunchArgument, names), publisher])


def display() -> LaunchDescription:
    """Show a robot, whose joints stand still: `jsp_gui` and `rviz_config` too."""
    usual = PathJoinSubstitution([FindPackageShare("urdf_launch"), "config", "urdf.rviz"])
    gui, joints = LaunchConfiguration("jsp_gui"), "joint_state_publisher"
    return LaunchDescription(
        [
            DeclareLaunchArgument("jsp_gui", default_value="true"),
            DeclareLaunchArgument("rviz_config", default_value=usual),
            *robot().entities,
            Node(package=joints, executable=joints, condition=UnlessCondition(gui)),
            Node(package=f"{joints}_gui", executable=f"{joints}_gui", condition=IfCondition(gui)),
            Node(
                package="rviz2",
                executable="rviz2",
                output="screen",
                arguments=["-d", LaunchConfiguration("rviz_config")],
            ),
        ]
    )


def teleop() -> LaunchDescription:
    """Drive by a joystick: `config_filepath`, `joy_dev`, `joy_vel`, `publish_stamped_twist`."""
    usual = {"joy_config": "ps3", "joy_dev": "0", "joy_vel": "cmd_vel", "config_filepath": ""}
    return LaunchDescription(
        [
            *(DeclareLaunchArgument(name, default_value=text) for name, text in usual.items()),
            DeclareLaunchArgument("publish_stamped_twist", default_value="false"),
            OpaqueFunction(function=_joystick),
        ]
    )


def _joystick(context: Any) -> list[Node]:
    given = context.launch_configurations
    number = given["joy_dev"].removeprefix("/dev/input/js")
    device = {"device_id": int(number)} if number.isdigit() else {}
    file = given["config_filepath"]
    stamped = {"publish_stamped_twist": LaunchConfiguration("publish_stamped_twist")}
    return [
        Node(
            package="joy",
            executable="joy_node",
            name="joy_node",
            parameters=[{**device, "deadzone": _DEADZONE, "autorepeat_rate": _RATE}],
        ),
        Node(
            package="teleop_twist_joy",
            executable="teleop_node",
            name="teleop_twist_joy_node",
            parameters=[*([file] if file else []), stamped],
            remappings=[("/cmd_vel", given["joy_vel"])],
        ),
    ]
