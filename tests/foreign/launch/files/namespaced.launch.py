from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace, SetParameter, SetRemap


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('namespace', default_value='turtlebot4'),
        SetParameter('use_sim_time', True),
        GroupAction([
            PushRosNamespace(LaunchConfiguration('namespace')),
            SetRemap('/tf', 'tf'),
            SetRemap('/tf_static', 'tf_static'),
            Node(package='my_robot', executable='talker', name='inside'),
            Node(package='my_robot', executable='talker', name='root', namespace='/'),
        ]),
        Node(package='my_robot', executable='talker', name='outside'),
    ])
