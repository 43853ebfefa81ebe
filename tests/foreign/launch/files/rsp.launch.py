import os

import xacro
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    xacro_file = os.path.join(get_package_share_directory('my_robot'), 'urdf', 'robot.urdf')
    assert xacro.process_file(xacro_file)
    description = Command(['xacro ', xacro_file, ' use_ros2_control:=',
                           LaunchConfiguration('use_ros2_control'), ' sim_mode:=',
                           LaunchConfiguration('use_sim_time')])
    params = {'robot_description': description,
              'use_sim_time': LaunchConfiguration('use_sim_time')}
    return LaunchDescription([
        DeclareLaunchArgument('use_sim_time', default_value='false'),
        DeclareLaunchArgument('use_ros2_control', default_value='true'),
        Node(package='robot_state_publisher', executable='robot_state_publisher',
             output='screen', parameters=[params]),
    ])
