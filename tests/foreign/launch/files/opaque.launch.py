import os

from ament_index_python.packages import get_package_share_path
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetLaunchConfiguration
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def launch_setup(context, *args, **kwargs):
    robot = LaunchConfiguration('robot').perform(context)
    count = int(context.launch_configurations['count'])
    folder = get_package_share_path('my_robot')
    assert os.path.isdir(folder)
    return [
        Node(package='my_robot', executable='talker', name=f'{robot}_{i}', namespace=robot,
             parameters=[{'index': i, 'gains': [1.0, 2.0], 'nested': {'deep': {'value': True}}}])
        for i in range(count)
    ] + [SetLaunchConfiguration('done', 'true')]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('robot', default_value='husky', choices=['husky', 'jackal']),
        DeclareLaunchArgument('count', default_value='2'),
        OpaqueFunction(function=launch_setup),
    ])
