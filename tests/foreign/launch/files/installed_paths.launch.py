from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node


def generate_launch_description():
    share = '/opt/ros/jazzy/share/'
    return LaunchDescription([
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(share + 'slam_toolbox/launch/online_async_launch.py'),
            launch_arguments={'slam_params_file': '/opt/ros/humble/share/no_package/a.yaml'}.items(),
        ),
        Node(
            package='nav2_map_server',
            executable='map_server',
            parameters=[{'yaml_filename': share + 'nav2_bringup/maps/tb3_sandbox.yaml'}],
        ),
        Node(
            package='rviz2',
            executable='rviz2',
            arguments=['-d', share + 'nav2_bringup/rviz/nav2_default_view.rviz'],
        ),
    ])
