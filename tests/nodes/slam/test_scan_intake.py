"""Claims: who gets no scans says why; a base frame that is not there has one that is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, se2_from_pose
from arjuna_slam.nodes.amcl import AmclNode
from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode
from tests.helpers.ros import RosBench
from tests.helpers.slam_robot import LOG, Robot, started
from tests.nodes.slam.nodes import Logged, activated


@pytest.mark.parametrize("cls", [SlamToolboxNode, AmclNode])
@pytest.mark.parametrize(
    ("kind", "topic", "reason"),
    [
        (None, "", "nobody publishes it; no node publishes scans"),
        (LaserScan, "/front/scan", "nobody publishes it; scans are on /front/scan: set scan_topic"),
        (LaserScan, "/scan", "bench_client would publish it and is silent"),
    ],
)
def test_no_scan_is_reported_within_five_seconds_and_once(
    bench: RosBench, logged: Logged, cls: Any, kind: Any, topic: str, reason: str
) -> None:
    if kind is not None:
        bench.node.create_publisher(kind, topic, qos.DEFAULT)
    activated(bench, cls)
    bench.advance(5.0)
    (warning,) = [text for text in logged.warnings if text.startswith("no scan comes")]
    assert warning.startswith(f"no scan comes on '/scan': {reason}")
    bench.advance(5.0)
    assert sum(text.startswith("no scan comes") for text in logged.warnings) == 1


def test_quality_of_service_that_does_not_fit_is_named(
    bench: RosBench, logged: Logged, monkeypatch: pytest.MonkeyPatch
) -> None:
    strict = QoSProfile(depth=5, reliability=qos.DEFAULT.reliability)
    monkeypatch.setattr(qos, "SENSOR_SUBSCRIPTION", strict)
    bench.node.create_publisher(LaserScan, "/scan", QoSProfile(depth=5, reliability=2))
    activated(bench, SlamToolboxNode)
    bench.advance(5.0)
    (warning,) = [text for text in logged.warnings if text.startswith("no scan comes")]
    assert "the quality of service of bench_client does not fit: ERROR: Best effort" in warning


def test_a_topic_of_another_type_is_named(
    bench: RosBench, logged: Logged, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = SimpleNamespace(topic_type="sensor_msgs/msg/PointCloud2")
    node = activated(bench, SlamToolboxNode)
    monkeypatch.setattr(node, "get_publishers_info_by_topic", lambda topic: [other])
    bench.advance(5.0)
    (warning,) = [text for text in logged.warnings if text.startswith("no scan comes")]
    assert "it is of sensor_msgs/msg/PointCloud2, not sensor_msgs/msg/LaserScan; no node" in warning


def test_where_scans_come_nothing_is_reported(robot: Robot, logged: Logged) -> None:
    started(robot)
    robot.drive(55)
    assert logged.warnings + logged.errors == []


class _BaseLink(Robot):
    """A robot whose odometry moves `base_link`."""

    base = "base_link"


def test_the_base_that_is_there_is_used_and_reported_once(bench: RosBench, logged: Logged) -> None:
    robot = _BaseLink(bench)
    started(robot)
    robot.drive(45)
    assert robot.maps
    (warning,) = [text for text in logged.warnings if "base_frame" in text]
    assert warning == (
        "base_frame is 'base_footprint', a frame that does not exist: 'base_link' moves in 'odom'"
        " and is used; set base_frame: base_link"
    )
    first = robot.k - len(robot.poses)
    expected = LOG[first][1] @ LOG[first][2].inverse() @ robot.truth
    assert se2_from_pose(robot.poses[-1].pose.pose).distance(expected) < 0.03


def test_amcl_finds_its_base_too(bench: RosBench, logged: Logged) -> None:
    robot = _BaseLink(bench)
    mapper = activated(bench, SlamToolboxNode, base_frame="base_link", minimum_time_interval=0.0)
    robot.drive(50)
    grid = mapper.slam.map()
    mapper.trigger_deactivate()
    start = {"set_initial_pose": True, "update_min_d": 0.05}
    activated(bench, AmclNode, **start)
    placed = bench.collect(PoseWithCovarianceStamped, "/amcl_pose", qos.LATCHED)
    bench.publish(OccupancyGridMsg, "map", grid_msg(grid, "map", 0.0), qos.LATCHED)
    robot.k = 0
    robot.drive(60)
    assert any("base_frame_id is 'base_footprint'" in text for text in logged.warnings)
    assert placed


def test_the_pose_s_entropy_follows_its_covariance(robot: Robot) -> None:
    received = robot.bench.collect(Float64, "/entropy")
    started(robot)
    robot.drive(10)
    assert 0 < len(received) <= len(robot.poses)
    assert -30.0 < received[-1].data < 0.0
