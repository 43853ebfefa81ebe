from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import Command, FindExecutable, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    share = FindPackageShare("my_robot")
    model = PathJoinSubstitution([share, "urdf", "robot.urdf"])
    description = ParameterValue(
        Command([FindExecutable(name="xacro"), " ", LaunchConfiguration("model")]), value_type=str
    )
    gui = LaunchConfiguration("gui")
    return LaunchDescription([
        DeclareLaunchArgument(name="gui", default_value="true", choices=["true", "false"]),
        DeclareLaunchArgument(name="model", default_value=model, description="Path of the URDF"),
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             parameters=[{"robot_description": description}]),
        Node(package="joint_state_publisher", executable="joint_state_publisher",
             condition=UnlessCondition(gui)),
        Node(package="joint_state_publisher_gui", executable="joint_state_publisher_gui",
             condition=IfCondition(gui)),
        Node(package="rviz2", executable="rviz2", output="screen",
             arguments=["-d", PathJoinSubstitution([share, "rviz", "urdf.rviz"])]),
    ])
