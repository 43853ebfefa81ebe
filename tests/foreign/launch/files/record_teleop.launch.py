from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, TextSubstitution
from launch_ros.actions import Node


def generate_launch_description():
    joy = LaunchConfiguration('joy_dev')
    return LaunchDescription([
        DeclareLaunchArgument('joy_vel', default_value='cmd_vel'),
        DeclareLaunchArgument('joy_dev', default_value='0'),
        DeclareLaunchArgument('record', default_value='true'),
        DeclareLaunchArgument('config', default_value=[TextSubstitution(text='xbox')]),
        Node(package='joy', executable='joy_node', name='joy_node',
             parameters=[{'device_id': joy, 'deadzone': 0.3}], on_exit=Shutdown()),
        Node(package='teleop_twist_joy', executable='teleop_node', name='teleop_twist_joy_node',
             parameters=[{'publish_stamped_twist': False}],
             remappings={('/cmd_vel', LaunchConfiguration('joy_vel'))}),
        ExecuteProcess(cmd=['ros2', 'bag', 'record', '-a'],
                       condition=IfCondition(LaunchConfiguration('record')), output='screen'),
    ])
