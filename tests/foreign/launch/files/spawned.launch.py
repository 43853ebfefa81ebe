import os
import tempfile

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (AppendEnvironmentVariable, DeclareLaunchArgument, ExecuteProcess,
                            IncludeLaunchDescription, OpaqueFunction, RegisterEventHandler)
from launch.conditions import IfCondition
from launch.event_handlers import OnShutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch.substitutions.command import Command
from launch.substitutions.find_executable import FindExecutable
from launch_ros.actions import Node
from nav2_common.launch import LaunchConfigAsBool


def generate_launch_description():
    mine = get_package_share_directory('my_robot')
    gz = get_package_share_directory('ros_gz_sim')
    namespace, simulates = LaunchConfiguration('namespace'), LaunchConfigAsBool('use_simulator')
    headless = LaunchConfigAsBool('headless')
    world = tempfile.mktemp(prefix='nav2_', suffix='.sdf')
    robot = os.path.join(mine, 'urdf', 'robot.urdf')
    return LaunchDescription([
        AppendEnvironmentVariable('GZ_SIM_RESOURCE_PATH', os.path.join(mine, 'models')),
        DeclareLaunchArgument('namespace', default_value=''),
        DeclareLaunchArgument('use_simulator', default_value='yes'),
        DeclareLaunchArgument('headless', default_value='False'),
        ExecuteProcess(cmd=['xacro', '-o', world, ['headless:=', headless], 'world.sdf.xacro'],
                       condition=IfCondition(simulates)),
        ExecuteProcess(cmd=['gz', 'sim', '-r', '-s', world], condition=IfCondition(simulates)),
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(os.path.join(gz, 'launch', 'gz_sim.launch.py')),
            launch_arguments={'gz_args': ['-v4 -g ']}.items(),
            condition=IfCondition(PythonExpression([simulates, ' and not ', headless]))),
        RegisterEventHandler(OnShutdown(on_shutdown=[OpaqueFunction(
            function=lambda _: os.remove(world) if os.path.exists(world) else None)])),
        Node(package='ros_gz_bridge', executable='parameter_bridge', namespace=namespace,
             parameters=[{'config_file': os.path.join(mine, 'config', 'bridge.yaml'),
                          'expand_gz_topic_names': True}]),
        Node(package='ros_gz_sim', executable='create', namespace=namespace, arguments=[
            '-name', LaunchConfiguration('robot_name', default='waffle'),
            '-string', Command([FindExecutable(name='xacro'), ' ', 'namespace:=', namespace, ' ',
                                robot]),
            '-x', LaunchConfiguration('x_pose', default='-2.00')]),
        Node(package='robot_state_publisher', executable='robot_state_publisher', parameters=[
            {'use_sim_time': LaunchConfiguration('use_sim_time', default='true')}]),
        Node(package='rclcpp_components', executable='component_container_isolated',
             name='nav2_container', namespace=namespace,
             arguments=['--ros-args', '--log-level', 'info']),
    ])
