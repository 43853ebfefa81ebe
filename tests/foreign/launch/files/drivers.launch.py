import os

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, LogInfo, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessStart
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes, Node
from launch_ros.descriptions import ComposableNode
from launch_ros.substitutions import FindPackageShare

try:
    get_package_share_directory('rf2o_laser_odometry')
    has_rf2o = True
except PackageNotFoundError:
    has_rf2o = False


def camera(context):
    share = get_package_share_directory('usb_cam')
    return [
        IncludeLaunchDescription(os.path.join(share, 'launch', 'camera.launch.py')),
        Node(package='my_robot', executable='talker', parameters=[os.path.join(share, 'a.yaml')]),
    ]


def generate_launch_description():
    rplidar = get_package_share_directory('rplidar_ros')
    container = ComposableNodeContainer(
        name='image_container',
        namespace='',
        package='rclcpp_components',
        executable='component_container',
        composable_node_descriptions=[],
        output='screen',
    )
    detector = ComposableNode(package='apriltag_ros', plugin='AprilTagNode', name='apriltag')
    return LaunchDescription([
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([rplidar, '/launch/rplidar_a1_launch.py'])
        ),
        IncludeLaunchDescription(
            PathJoinSubstitution([FindPackageShare('realsense2_camera'), 'launch', 'rs_launch.py'])
        ),
        IncludeLaunchDescription(
            PathJoinSubstitution([FindPackageShare('robot_localization'), 'launch/ekf.launch.py'])
        ),
        OpaqueFunction(function=camera),
        RegisterEventHandler(
            OnProcessStart(
                target_action=container,
                on_start=[
                    LogInfo(msg='container started'),
                    LoadComposableNodes(
                        target_container=container, composable_node_descriptions=[detector]
                    ),
                ],
            )
        ),
        container,
        Node(package='my_robot', executable='talker', name=f'rf2o_{has_rf2o}'),
        Node(package='my_robot', executable='no_cpp_node'),
    ])
