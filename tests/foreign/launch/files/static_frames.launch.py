import launch
import launch_ros.actions


def generate_launch_description():
    return launch.LaunchDescription([
        launch_ros.actions.Node(
            package='tf2_ros', executable='static_transform_publisher',
            arguments=['--x', '0.1', '--frame-id', 'base_link', '--child-frame-id', 'laser']),
        launch_ros.actions.Node(
            package='tf2_ros', executable='static_transform_publisher',
            arguments='0 0 0.2 0 0 0 base_link imu_link'.split(' ')),
        launch_ros.actions.Node(
            package='rplidar_ros', executable='rplidar_node', name='rplidar_node',
            parameters=[{'serial_port': '/dev/ttyUSB0', 'serial_baudrate': 115200,
                         'frame_id': 'laser', 'angle_compensate': True}], output='screen'),
        launch_ros.actions.Node(
            package='laser_filters', executable='scan_to_scan_filter_chain',
            remappings=[('scan', 'scan_raw')]),
        launch.actions.RegisterEventHandler(launch.event_handlers.OnShutdown(
            on_shutdown=[launch.actions.LogInfo(msg='bye')])),
    ])
