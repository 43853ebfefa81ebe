import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import ExecuteProcess, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node


def include(package, file, **arguments):
    share = get_package_share_directory(package)
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(os.path.join(share, 'launch', file)),
        launch_arguments=arguments.items(),
    )


def generate_launch_description():
    burger = get_package_share_directory('nav2_minimal_tb3_sim')
    warehouse = get_package_share_directory('nav2_minimal_tb4_sim')
    with open(os.path.join(burger, 'urdf', 'turtlebot3_waffle.urdf')) as file:
        description = file.read()
    bridge = os.path.join(burger, 'configs', 'turtlebot3_waffle_bridge.yaml')
    box = os.path.join(burger, 'urdf', 'cardboard_box.sdf')
    return LaunchDescription([
        ExecuteProcess(cmd=[
            'gz', 'sim', '-r', '-s', os.path.join(burger, 'worlds', 'tb3_sandbox.sdf.xacro')]),
        include('nav2_minimal_tb3_sim', 'spawn_tb3.launch.py', x_pose='1.0',
                robot_sdf=os.path.join(burger, 'urdf', 'gz_waffle.sdf.xacro')),
        include('nav2_minimal_tb3_sim', 'spawn_tb3.launch.py', use_simulator='False'),
        Node(package='robot_state_publisher', executable='robot_state_publisher',
             parameters=[{'use_sim_time': True, 'robot_description': description}]),
        Node(package='ros_gz_bridge', executable='parameter_bridge',
             parameters=[{'config_file': bridge}]),
        Node(package='ros_gz_sim', executable='create',
             arguments=['-entity', 'cardboard_box', '-file', box, '-z', '0.15']),
        ExecuteProcess(cmd=['gz', 'sim', os.path.join(warehouse, 'worlds', 'depot.sdf')]),
        include('explore_lite', 'explore.launch.py'),
        include('nav2_minimal_tb4_sim', 'spawn_tb4.launch.py', namespace='second',
                robot_name='two', use_simulator='True', x_pose='-8.0'),
    ])
