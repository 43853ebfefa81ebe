from launch import LaunchDescription
from launch.actions import GroupAction, IncludeLaunchDescription, LogInfo
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, TextSubstitution
from launch_ros.actions import Node, PushROSNamespace
from launch_ros.substitutions import FindPackageShare

ROBOTS = [{'name': 'robot1', 'x': 0.0}, {'name': 'robot2', 'x': 1.5}]


def generate_launch_description():
    launch = PathJoinSubstitution([FindPackageShare('nav2_bringup'), 'launch'])
    found = []
    for robot in ROBOTS:
        found.append(GroupAction([
            PushROSNamespace(robot['name']),
            Node(package='ros_gz_sim', executable='create', arguments=[
                '-name', TextSubstitution(text=str(robot['name'])), '-x', str(robot['x']),
                '-topic', 'robot_description']),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(
                    PathJoinSubstitution([launch, 'navigation_launch.py'])),
                launch_arguments={'namespace': robot['name'], 'use_sim_time': 'True'}.items()),
            LogInfo(msg=['started ', LaunchConfiguration('namespace')]),
        ]))
    return LaunchDescription(found)
