import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import EnvironmentVariable, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    laser = os.getenv('LINOROBOT2_LASER_SENSOR', '')
    ekf = PathJoinSubstitution([FindPackageShare('my_robot'), 'config', 'ekf.yaml'])
    return LaunchDescription([
        DeclareLaunchArgument(name='base_serial_port', default_value='/dev/ttyACM0'),
        DeclareLaunchArgument(name='joy', default_value='false'),
        Node(package='micro_ros_agent', executable='micro_ros_agent', name='micro_ros_agent',
             arguments=['serial', '--dev', LaunchConfiguration('base_serial_port')]),
        Node(package='robot_localization', executable='ekf_node', name='ekf_filter_node',
             parameters=[ekf, {'laser': laser, 'home': EnvironmentVariable('HOME')}],
             remappings=[('odometry/filtered', 'odom')]),
        Node(package='joy_linux', executable='joy_linux_node',
             condition=IfCondition(LaunchConfiguration('joy'))),
    ])
