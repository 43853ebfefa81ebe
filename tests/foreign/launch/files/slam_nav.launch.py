from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    slam = PathJoinSubstitution(
        [FindPackageShare('slam_toolbox'), 'launch', 'online_async_launch.py'])
    nav = PathJoinSubstitution(
        [FindPackageShare('nav2_bringup'), 'launch', 'navigation_launch.py'])
    config = PathJoinSubstitution([FindPackageShare('my_robot'), 'config', 'slam.yaml'])
    sim = LaunchConfiguration('sim')
    return LaunchDescription([
        DeclareLaunchArgument(name='sim', default_value='false'),
        DeclareLaunchArgument(name='rviz', default_value='false'),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(nav), launch_arguments={
            'use_sim_time': sim}.items()),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(slam), launch_arguments={
            'use_sim_time': sim, 'slam_params_file': config}.items()),
        Node(package='rviz2', executable='rviz2', condition=IfCondition(
            LaunchConfiguration('rviz'))),
    ])
