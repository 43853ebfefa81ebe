from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode


def generate_launch_description():
    return LaunchDescription([
        ComposableNodeContainer(
            name='image_container', namespace='', package='rclcpp_components',
            executable='component_container',
            composable_node_descriptions=[
                ComposableNode(package='image_proc', plugin='image_proc::RectifyNode',
                               name='rectify', remappings=[('image', 'camera/image_raw')]),
                ComposableNode(package='depthimage_to_laserscan',
                               plugin='depthimage_to_laserscan::DepthImageToLaserScanROS',
                               parameters=[{'range_max': 8.0}]),
            ]),
        Node(package='realsense2_camera', executable='realsense2_camera_node'),
    ])
