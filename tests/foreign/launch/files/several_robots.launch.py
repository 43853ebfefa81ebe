from pathlib import Path

from launch import LaunchDescription
from launch.actions import (DeclareLaunchArgument, ForEach, ForLoop, GroupAction,
                            IncludeLaunchDescription, LogInfo)
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import AllSubstitution, AnySubstitution, LaunchConfiguration
from launch_ros.actions import LifecycleTransition, ROSTimer
from launch_xml.launch_description_sources import XMLLaunchDescriptionSource
from nav2_common.launch import ParseMultiRobotPose

HERE = Path(__file__).parent


def of_robot(name, pose={}):
    return [GroupAction([IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(HERE / 'spawned.launch.py')),
        launch_arguments={'namespace': name, 'use_simulator': 'False', 'robot_name': name,
                          'x_pose': str(pose.get('x', 0.0))}.items())])]


def generate_launch_description():
    given = ParseMultiRobotPose('poses').value()
    return LaunchDescription([
        DeclareLaunchArgument(
            'robots', default_value="{name: 'robot1', pose: {x: 0.5}};{name: 'robot2'}"),
        ForEach(LaunchConfiguration('robots'), function=of_robot),
        *(LogInfo(msg=f"{name} {pose['x']} {pose['yaw']}") for name, pose in given.items()),
        ForLoop('2', function=lambda i: [LogInfo(msg=f'number {i}')],
                condition=IfCondition(AllSubstitution('true', AnySubstitution('false', '1')))),
        LifecycleTransition(lifecycle_node_names=['slam_toolbox'], transition_ids=[1, '3']),
        ROSTimer(period=0.01, actions=[LogInfo(msg='timed')]),
        IncludeLaunchDescription(XMLLaunchDescriptionSource(str(HERE / 'demo_launch.xml')),
                                 condition=IfCondition('false')),
    ])
