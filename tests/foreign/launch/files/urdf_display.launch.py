from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    ld = LaunchDescription()
    ld.add_action(DeclareLaunchArgument(name='gui', default_value='true', choices=['true', 'false']))
    ld.add_action(
        DeclareLaunchArgument(
            name='model', default_value=PathJoinSubstitution(['urdf', 'robot.urdf'])
        )
    )
    ld.add_action(
        IncludeLaunchDescription(
            PathJoinSubstitution([FindPackageShare('urdf_launch'), 'launch', 'display.launch.py']),
            launch_arguments={
                'urdf_package': 'my_robot',
                'urdf_package_path': LaunchConfiguration('model'),
                'jsp_gui': LaunchConfiguration('gui'),
            }.items(),
        )
    )
    ld.add_action(
        IncludeLaunchDescription(
            [FindPackageShare('teleop_twist_joy'), '/launch/teleop-launch.py'],
            launch_arguments={
                'joy_config': 'xbox',
                'joy_vel': '/joy_vel',
                'joy_dev': '/dev/input/js1',
                'publish_stamped_twist': 'True',
            }.items(),
        )
    )
    return ld
