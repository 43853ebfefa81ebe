from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.conditions import IfCondition, LaunchConfigurationEquals
from launch.substitutions import (
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    PythonExpression,
)
from launch_ros.actions import Node, PushRosNamespace


def generate_launch_description():
    mode = LaunchConfiguration('mode')
    return LaunchDescription([
        DeclareLaunchArgument('mode', default_value='slam'),
        DeclareLaunchArgument('use_namespace', default_value='False'),
        GroupAction([
            PushRosNamespace(condition=IfCondition(LaunchConfiguration('use_namespace')),
                             namespace='ns'),
            Node(condition=IfCondition(EqualsSubstitution(mode, 'slam')), package='slam_toolbox',
                 executable='sync_slam_toolbox_node', name='slam_toolbox'),
            Node(condition=IfCondition(PythonExpression(["'", mode, "' == 'amcl'"])),
                 package='nav2_amcl', executable='amcl', name='amcl'),
            Node(condition=LaunchConfigurationEquals('mode', 'slam'),
                 package='nav2_map_server', executable='map_saver_server',
                 parameters=[{'save_map_timeout': IfElseSubstitution('true', '5.0', '1.0')}]),
        ]),
    ])
