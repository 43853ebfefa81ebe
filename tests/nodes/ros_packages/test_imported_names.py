"""What programs import: names that the originals' modules hold only because they use them."""

from __future__ import annotations

import importlib
import os
import signal
import subprocess

import pytest
from nav2_simple_commander.utils import find_os_processes, kill_os_processes

from tests.helpers.processes import wait_until

_ACTIONS = (
    "AssistedTeleop BackUp ComputePathThroughPoses ComputePathToPose FollowGPSWaypoints FollowPath "
    "FollowWaypoints NavigateThroughPoses NavigateToPose SmoothPath Spin"
)
_NAMES = {
    "nav2_simple_commander.robot_navigator": (
        f"{_ACTIONS} BasicNavigator TaskResult ActionClient ClearEntireCostmap Duration Enum "
        "GetCostmap GetState GoalStatus LoadMap ManageLifecycleNodes Node Point PoseStamped "
        "PoseWithCovarianceStamped QoSDurabilityPolicy QoSHistoryPolicy QoSProfile "
        "QoSReliabilityPolicy rclpy rclpyDuration time"
    ),
    "nav2_simple_commander.utils": "find_os_processes kill_os_processes kill_process",
    "tf2_ros": "TransformStamped TFMessage Header Duration Time Node QoSProfile DurabilityPolicy",
    "tf2_ros.buffer": "Buffer",
    "tf2_ros.transform_listener": "TransformListener",
    "tf2_ros.transform_broadcaster": "TransformBroadcaster",
    "tf2_ros.static_transform_broadcaster": "StaticTransformBroadcaster",
    "tf2_geometry_msgs": (
        "PointStamped Pose PoseStamped PoseWithCovarianceStamped TransformStamped Vector3Stamped"
    ),
    "sensor_msgs_py.point_cloud2": "PointCloud2 PointField Header np",
    "rosbag2_py._compression_options": "CompressionMode CompressionOptions",
    "rosbag2_py._info": "Info",
    "rosbag2_py": "bag_rewrite convert_rclcpp_qos_to_rclpy_qos to_rclcpp_qos_vector",
    "rosbag2_py._message_definitions": "LocalMessageDefinitionSource",
    "rosbag2_py._reader": "SequentialReader SequentialCompressionReader",
    "rosbag2_py._reindexer": "Reindexer",
    "rosbag2_py._storage": (
        "StorageOptions ConverterOptions StorageFilter TopicMetadata QoS Duration "
        "rmw_qos_durability_policy_t rmw_qos_history_policy_t rmw_qos_liveliness_policy_t "
        "rmw_qos_reliability_policy_t convert_rclcpp_qos_to_rclpy_qos to_rclcpp_qos_vector"
    ),
    "rosbag2_py._transport": (
        "Player PlayOptions Recorder RecordOptions ServiceRequestsSource bag_rewrite"
    ),
    "rosbag2_py._writer": "SequentialWriter SequentialCompressionWriter",
}


@pytest.mark.parametrize("module", sorted(_NAMES))
def test_names_that_the_originals_modules_import_are_there(module: str) -> None:
    held = importlib.import_module(module)
    assert [name for name in _NAMES[module].split() if not hasattr(held, name)] == []


def test_modules_that_are_compiled_there_are_attributes_too() -> None:
    import rosbag2_py

    options = rosbag2_py._storage.StorageOptions(uri="a", storage_id="mcap")
    assert options == rosbag2_py.StorageOptions(uri="a", storage_id="mcap")
    assert rosbag2_py._reader.SequentialReader is rosbag2_py.SequentialReader


def test_processes_are_ended_by_the_beginning_of_their_commands(
    capsys: pytest.CaptureFixture[str],
) -> None:
    sleeper = subprocess.Popen(["sleep", "61.25"])
    # The kernel shows a new program's words a moment after it has begun.
    wait_until(lambda: find_os_processes("sleep 61.25"), os.sched_yield, "the sleeper's command")
    assert find_os_processes("sleep 61.25") == [(str(sleeper.pid), "sleep 61.25")]
    assert find_os_processes("") == []
    kill_os_processes("sleep 61.25")
    assert sleeper.wait(10.0) == -signal.SIGKILL
    kill_os_processes("sleep 61.25")
    said = capsys.readouterr().out.splitlines()
    assert said == [
        f"Successfully killed process with PID: {sleeper.pid}",
        "No processes found starting with sleep 61.25",
    ]
