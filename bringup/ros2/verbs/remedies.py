"""Remedies for what is not there."""

from __future__ import annotations

from collections.abc import Sequence

from arjuna_core.files.shipped import environment_folders

_DRIVER = (
    "its driver is ROS's: run it beside 'arjuna robot'; 'arjuna sim' publishes the same topics"
)
_DRIVERS = """rplidar_ros sllidar_ros2 ldlidar_stl_ros2 ydlidar_ros2_driver hls_lfcd_lds_driver
urg_node sick_scan_xd velodyne_driver realsense2_camera usb_cam v4l2_camera depthai_ros_driver
astra_camera camera_ros diffdrive_arduino imu_bno055 kobuki_node ldlidar ldlidar_node
ldlidar_ros2 lslidar_driver micro_ros_agent mpu6050driver nmea_navsat_driver orbbec_camera
ros2_laser_scan_matcher ros2_mpu6050_driver serial_driver turtlebot3_node ublox_gps zed_wrapper"""
REMEDIES = {
    "": "'source install/setup.bash' of its workspace first; 'ros2 pkg list' has all there are",
    **dict.fromkeys(_DRIVERS.split(), _DRIVER),
    "cartographer_ros": "'ros2 launch slam_toolbox online_async_launch.py' maps",
    "rtabmap_slam": "'ros2 launch slam_toolbox online_async_launch.py' maps, in 2D",
    "nav2_simple_commander": "its demos are of worlds of their own: 'ros2 run FILE.py' runs what"
    " imports it, beside 'arjuna nav'",
    "rosbag2_transport": "'ros2 bag record' and 'ros2 bag play' do the same",
    "rqt_gui": "'arjuna view' has plots and nodes",
    "rqt_graph": "'arjuna view --foxglove' serves Foxglove, whose panel Topic Graph draws it",
    **dict.fromkeys(
        ("image_tools", "image_view", "rqt_image_view"), "'arjuna view' shows pictures of cameras"
    ),
    **dict.fromkeys(("plotjuggler", "rqt_plot"), "'arjuna view' has plots"),
    "rqt_console": "'ros2 topic echo /rosout' has all nodes' messages",
    "rqt_robot_steering": "'arjuna view' and 'arjuna teleop' drive",
    "rqt_tf_tree": "'ros2 run tf2_tools view_frames' draws it",
    "rqt_reconfigure": "'arjuna view --foxglove' serves Foxglove, whose panel Parameters sets them",
    "moveit_ros_move_group": "arms are not planned for here",
    "interactive_marker_twist_server": "'arjuna view' and 'arjuna teleop' drive",
    "turtlebot3_bringup": _DRIVER,
    "moveit_configs_utils": "arms are not planned for here",
    "webots_ros2_driver": "worlds of Webots are not read: 'arjuna sim' simulates",
}
"""What to do instead, by the package that is not there."""


_OF_PIP = {
    "cv2": "opencv-contrib-python", "PIL": "pillow", "py_trees": "py-trees",
    "serial": "pyserial", "simple_pid": "simple-pid", "skimage": "scikit-image",
    "sklearn": "scikit-learn", "smbus": "smbus2", "usb": "pyusb", "zmq": "pyzmq",
}  # fmt: skip
"""What pip calls modules of other names."""
_OF_ROS = ("_msgs", "_msg", "_srvs", "_interfaces", "_interface", "_ros", "_ros2")


def remedy_of_module(name: str) -> str:
    """Return what brings a module that a program of a user's imports."""
    package = name.partition(".")[0]
    if package in REMEDIES:
        return REMEDIES[package]
    if package.endswith(_OF_ROS) or package.startswith("ros2"):
        return "put the package's sources into your workspace's src, 'colcon build' and source it"
    pip = f"'python -m pip install {_OF_PIP.get(package, package)}' brings what pip has"
    return f"{pip}; a package of your own: 'source install/setup.bash' first"


def remedy_of(package: str, programs: Sequence[str]) -> str:
    """Return what to do where a package, or something of it, is not there."""
    shares = (folder / "share" for folder in environment_folders("AMENT_PREFIX_PATH"))
    is_there = package != "" and any((share / package).is_dir() for share in shares)
    if package in REMEDIES or not (programs or is_there):
        return REMEDIES.get(package, REMEDIES[""])
    if programs:
        return f"of it there is 'ros2 run {package} {'|'.join(programs)}'"
    return "programs of C++ are built by ROS's own tools"
