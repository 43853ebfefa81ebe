"""Remedies for what is not there."""

from __future__ import annotations

import re
import traceback
from collections.abc import Sequence
from importlib.util import find_spec

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
    "web_video_server": "'arjuna view' shows pictures of cameras in a browser",
    "multirobot_map_merge": "'ros2 launch slam_toolbox merge_maps_kinematic_launch.py' merges"
    " graphs that were saved",
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
PIP = {
    "PIL": "pillow",
    "RPi": "RPi.GPIO",
    "cv2": "opencv-python",
    "py_trees": "py-trees",
    "serial": "pyserial",
    "simple_pid": "simple-pid",
    "skimage": "scikit-image",
    "sklearn": "scikit-learn",
    "smbus": "smbus2",
    "usb": "pyusb",
    "yaml": "pyyaml",
    "zmq": "pyzmq",
}
"""Names by which pip knows modules of other names."""
_MESSAGES = re.compile(r"\w+_(msgs|interfaces?|srvs|actions)")


def remedy_of(package: str, programs: Sequence[str]) -> str:
    """Return what to do where a package, or something of it, is not there."""
    shares = (folder / "share" for folder in environment_folders("AMENT_PREFIX_PATH"))
    is_there = package != "" and any((share / package).is_dir() for share in shares)
    if package in REMEDIES or not (programs or is_there):
        return REMEDIES.get(package, REMEDIES[""])
    if programs:
        return f"of it there is 'ros2 run {package} {'|'.join(programs)}'"
    return "programs of C++ are built by ROS's own tools"


def missing(error: ModuleNotFoundError) -> str:
    """Return which module a program of one's own lacks, and what to do."""
    module, place = str(error.name), ""
    lines = [each for each in traceback.extract_tb(error.__traceback__) if each.filename[0] != "<"]
    if lines:
        place = f"{lines[-1].filename}, line {lines[-1].lineno}: "
    return f"{place}the module '{module}' is not installed; {module_remedy(module)}"


def module_remedy(module: str) -> str:
    """Return what to do where a program imports a module that is not there."""
    package, _, part = module.partition(".")
    if part and find_spec(package) is not None:
        return f"'{package}' has no such part: its file, or a folder in setup.py's packages, lacks"
    if package in REMEDIES:
        return REMEDIES[package]
    if _MESSAGES.fullmatch(package):
        return "'colcon build' builds messages of a workspace, 'arjuna messages FOLDER' any"
    return f"'pip install {PIP.get(package, package)}' may bring it; of your own: {REMEDIES['']}"
