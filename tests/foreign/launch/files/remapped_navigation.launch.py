"""Navigation whose commands another node checks, as a student's course writes it."""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, SetRemap
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    share = get_package_share_directory('my_robot')
    nav2 = os.path.join(get_package_share_directory('nav2_bringup'), 'launch')
    sim = LaunchConfiguration('sim', default='false')
    filters = os.path.join(share, 'config', 'filters.yaml')
    zones = {'use_sim_time': sim, 'params_file': filters, 'graph': 'halls.geojson', 'keepout_mask': 'no.yaml'}
    return LaunchDescription([
        DeclareLaunchArgument('sim', default_value='false'),
        Node(package='nav2_map_server', executable='costmap_filter_info_server',
             name='lanes_filter_info_server', parameters=[filters]),
        GroupAction([
            SetRemap(src='/cmd_vel', dst='/cmd_vel_nav_out'),
            SetRemap(src='/scan', dst='/scan_filtered'),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(os.path.join(nav2, 'bringup_launch.py')),
                launch_arguments={'map': 'my_map.yaml', **zones}.items(),
            ),
        ]),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([FindPackageShare('twist_mux'), '/launch/twist_mux_launch.py']),
            launch_arguments={'cmd_vel_out': 'cmd_vel', 'use_sim_time': sim}.items(),
        ),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(
            [FindPackageShare('robot_localization'), '/launch/ekf.launch.py'])),
        IncludeLaunchDescription(PythonLaunchDescriptionSource(
            [FindPackageShare('nav2_route'), '/launch/route_tool.launch.py'])),
    ])
