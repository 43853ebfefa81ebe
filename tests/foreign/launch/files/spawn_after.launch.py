from launch import LaunchDescription
from launch.actions import ExecuteProcess, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnExecutionComplete, OnProcessExit
from launch.substitutions import FindExecutable, LocalSubstitution
from launch_ros.actions import Node


def generate_launch_description():
    create = Node(package='ros_gz_sim', executable='create', arguments=['-file', 'robot.sdf'])
    call = ExecuteProcess(
        cmd=[[FindExecutable(name='ros2'), ' service call ', '/spawn ', 'std_srvs/srv/Trigger']],
        shell=True)
    broadcaster = ExecuteProcess(
        cmd=['ros2', 'control', 'load_controller', '--set-state', 'active', 'joint_broad'],
        output='screen')
    return LaunchDescription([
        create, call,
        RegisterEventHandler(OnProcessExit(target_action=create, on_exit=[broadcaster])),
        RegisterEventHandler(OnExecutionComplete(
            target_action=call, on_completion=[OpaqueFunction(function=lambda c: None)])),
        RegisterEventHandler(OnProcessExit(
            target_action=call,
            on_exit=lambda event, context: [OpaqueFunction(
                function=lambda c: LocalSubstitution('event.returncode').perform(c) and None)])),
    ])
