import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node


def generate_launch_description():
    package_name = 'my_robot'
    share = get_package_share_directory(package_name)
    rsp = IncludeLaunchDescription(
        PythonLaunchDescriptionSource([os.path.join(share, 'launch', 'rsp.launch.py')]),
        launch_arguments={'use_sim_time': 'true', 'use_ros2_control': 'true'}.items())
    twist_mux = Node(
        package='twist_mux', executable='twist_mux',
        parameters=[os.path.join(share, 'config', 'twist_mux.yaml'), {'use_sim_time': True}],
        remappings=[('/cmd_vel_out', '/diff_cont/cmd_vel_unstamped')])
    gazebo = IncludeLaunchDescription(
        PythonLaunchDescriptionSource([os.path.join(
            get_package_share_directory('gazebo_ros'), 'launch', 'gazebo.launch.py')]),
        launch_arguments={'extra_gazebo_args': '--ros-args --params-file x.yaml'}.items())
    spawn_entity = Node(
        package='gazebo_ros', executable='spawn_entity.py',
        arguments=['-topic', 'robot_description', '-entity', 'my_bot'], output='screen')
    drive = Node(package='controller_manager', executable='spawner', arguments=['diff_cont'])
    broad = Node(package='controller_manager', executable='spawner', arguments=['joint_broad'])
    return LaunchDescription([rsp, twist_mux, gazebo, spawn_entity, drive, broad])
