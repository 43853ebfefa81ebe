import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import RegisterEventHandler, TimerAction
from launch.event_handlers import OnProcessStart
from launch_ros.actions import Node


def generate_launch_description():
    share = get_package_share_directory('my_robot')
    controller_params = os.path.join(share, 'config', 'twist_mux.yaml')
    manager = Node(
        package='controller_manager', executable='ros2_control_node',
        parameters=[{'robot_description': '<robot name="r"/>'}, controller_params])
    spawner = Node(package='controller_manager', executable='spawner', arguments=['diff_cont'])
    return LaunchDescription([
        TimerAction(period=0.05, actions=[manager]),
        RegisterEventHandler(event_handler=OnProcessStart(
            target_action=manager, on_start=[spawner])),
    ])
