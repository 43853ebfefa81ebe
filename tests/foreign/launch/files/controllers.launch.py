"""Controllers by ros2_control's helpers: each alone, several of one file, and of files each."""

import os

from ament_index_python.packages import get_package_share_directory
from controller_manager.launch_utils import (
    generate_controllers_spawner_launch_description,
    generate_controllers_spawner_launch_description_from_dict,
    generate_load_controller_launch_description,
)
from launch import LaunchDescription


def generate_launch_description():
    config = os.path.join(get_package_share_directory('my_robot'), 'config', 'ekf.yaml')
    alone = generate_load_controller_launch_description('joint_state_broadcaster')
    arm = generate_controllers_spawner_launch_description(
        ['arm', 'gripper'], [config], extra_spawner_args=['--inactive'])
    base = generate_controllers_spawner_launch_description_from_dict(
        {'base': [config], 'imu': None})
    return LaunchDescription([alone, arm, base])
