import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

TURTLEBOT3_MODEL = os.environ.get('TURTLEBOT3_MODEL', 'burger')


def generate_launch_description():
    use_sim_time = LaunchConfiguration('use_sim_time', default='false')
    folder = get_package_share_directory('turtlebot3_navigation2')
    map_dir = LaunchConfiguration('map', default=os.path.join(folder, 'map', 'map.yaml'))
    param_dir = LaunchConfiguration(
        'params_file', default=os.path.join(folder, 'param', TURTLEBOT3_MODEL + '.yaml'))
    nav2_launch_file_dir = os.path.join(get_package_share_directory('nav2_bringup'), 'launch')
    rviz = os.path.join(
        get_package_share_directory('nav2_bringup'), 'rviz', 'nav2_default_view.rviz')
    return LaunchDescription([
        DeclareLaunchArgument('map', default_value=map_dir),
        DeclareLaunchArgument('params_file', default_value=param_dir),
        DeclareLaunchArgument('use_sim_time', default_value='false'),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([nav2_launch_file_dir, '/bringup_launch.py']),
            launch_arguments={'map': map_dir, 'use_sim_time': use_sim_time,
                              'params_file': param_dir}.items(),
        ),
        Node(package='rviz2', executable='rviz2', name='rviz2', arguments=['-d', rviz],
             parameters=[{'use_sim_time': use_sim_time}], output='screen'),
    ])
