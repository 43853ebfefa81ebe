import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    AppendEnvironmentVariable,
    DeclareLaunchArgument,
    IncludeLaunchDescription,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    ros_gz_sim = get_package_share_directory('ros_gz_sim')
    world = os.path.join(
        get_package_share_directory('turtlebot3_gazebo'), 'worlds', 'turtlebot3_world.world')
    gzserver_cmd = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(os.path.join(ros_gz_sim, 'launch', 'gz_sim.launch.py')),
        launch_arguments={'gz_args': ['-r -s -v2 ', world], 'on_exit_shutdown': 'true'}.items(),
    )
    models = AppendEnvironmentVariable('GZ_SIM_RESOURCE_PATH', '/opt/models')
    x_pose = LaunchConfiguration('x_pose', default='-2.0')
    spawn = Node(
        package='ros_gz_sim', executable='create', output='screen',
        arguments=['-name', 'burger', '-topic', 'robot_description', '-x', x_pose, '-y', '-0.5'])
    bridge = Node(
        package='ros_gz_bridge', executable='parameter_bridge',
        arguments=['/clock@rosgraph_msgs/msg/Clock[gz.msgs.Clock'])
    ld = LaunchDescription()
    ld.add_action(DeclareLaunchArgument('x_pose', default_value='-2.0'))
    ld.add_action(models)
    ld.add_action(gzserver_cmd)
    ld.add_action(spawn)
    ld.add_action(bridge)
    return ld
