"""Launch files of other packages whose nodes are here: what a launch file of one's own includes."""

from __future__ import annotations

import os
from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from arjuna_core.files.input_file import read_text
from arjuna_core.files.shipped import shipped_file

_MODEL = "TURTLEBOT3_MODEL"
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


def turtlebot3_description() -> LaunchDescription:
    """Publish the Burger's description and its frames: `use_sim_time`, `frame_prefix`."""
    prefix = LaunchConfiguration("frame_prefix", default="")
    return LaunchDescription(
        [
            DeclareLaunchArgument("use_sim_time", default_value="false"),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                name="robot_state_publisher",
                output="screen",
                parameters=[
                    {
                        "use_sim_time": LaunchConfiguration("use_sim_time"),
                        "robot_description": read_text(shipped_file("urdf/burger.urdf")),
                        "frame_prefix": ParameterValue(prefix, value_type=str),
                    }
                ],
            ),
        ]
    )


def turtlebot3_spawn() -> LaunchDescription:
    """Put the Burger into the world: `x_pose`, `y_pose`."""
    x, y = (LaunchConfiguration(f"{axis}_pose", default="0.0") for axis in "xy")
    file = str(shipped_file("urdf/burger.urdf"))
    words: list[Any] = ["-name", "burger", "-file", file, "-x", x, "-y", y, "-z", "0.01"]
    spawner = Node(package="ros_gz_sim", executable="create", arguments=words, output="screen")
    model = os.environ.get(_MODEL, "burger")
    remark = LogInfo(msg=f"the Burger stands for {_MODEL}={model}")
    return LaunchDescription([*([remark] if model != "burger" else []), spawner])


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
