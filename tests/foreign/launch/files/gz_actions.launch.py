import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from ros_gz_bridge.actions import RosGzBridge
from ros_gz_sim.actions import GzServer


def generate_launch_description():
    ros_gz_sim_share = get_package_share_directory('ros_gz_sim')
    spawn_source = os.path.join(ros_gz_sim_share, 'launch', 'gz_spawn_model.launch.py')
    bridge_config = os.path.join(get_package_share_directory('my_robot'), 'config', 'bridge.yaml')
    gz_server = GzServer(
        world_sdf_file='empty.sdf',
        container_name='ros_gz_container',
        create_own_container='True',
        use_composition='True',
    )
    ros_gz_bridge = RosGzBridge(
        bridge_name='ros_gz_bridge',
        config_file=bridge_config,
        container_name='ros_gz_container',
        create_own_container='False',
        use_composition='True',
    )
    spawn_entity = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(spawn_source),
        launch_arguments={
            'world': 'my_world',
            'topic': '/robot_description',
            'entity_name': 'sam_bot',
            'z': '0.65',
        }.items(),
    )
    return LaunchDescription([gz_server, ros_gz_bridge, spawn_entity])
