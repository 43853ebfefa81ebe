"""Scans, clouds, depth images, inertial readings, joints: each node with messages as they come."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import (
    CameraInfo,
    Image,
    Imu,
    JointState,
    LaserScan,
    MagneticField,
    PointCloud2,
)
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_from_msg, cloud_msg, header, transform3_msg
from arjuna_sim.nodes.processing.imu_filter import ImuFilterNode
from arjuna_sim.nodes.processing.joint_state_publisher import (
    SLIDERS,
    JointStatePublisherNode,
)
from arjuna_sim.nodes.processing.laser_filters import ScanFilterChainNode
from arjuna_sim.nodes.processing.to_scan import (
    DepthimageToLaserscanNode,
    LaserscanToPointcloudNode,
    PointcloudToLaserscanNode,
)
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import start

BEHIND = Pose3((-0.1, 0.0, 0.5))


def _mount(bench: RosBench, child: str, T: Pose3 = BEHIND) -> None:
    transform = transform3_msg(T, "base_link", child, 0.0)
    bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[transform]), qos.TF_STATIC)


def _scan() -> LaserScan:
    message = LaserScan(header=header("laser", 1.0), angle_min=-0.2, angle_max=0.2)
    message.angle_increment, message.range_min, message.range_max = 0.1, 0.1, 10.0
    message.time_increment = 0.01
    message.ranges = [1.0, 2.0, 0.4, 4.0, 5.0]
    message.intensities = [1.0, 2.0, 3.0, 4.0, 5.0]
    return message


def test_a_scan_passes_the_filters_in_their_order(bench: RosBench) -> None:
    values = {
        "filter1": {
            "name": "angle",
            "type": "laser_filters/LaserScanAngularBoundsFilter",
            "params": {"lower_angle": -0.15, "upper_angle": 0.25},
        },
        "filter2": {
            "name": "box",
            "type": "laser_filters/LaserScanBoxFilter",
            "params": {
                "box_frame": "base_link",
                "min_x": 0.0,
                "max_x": 0.5,
                "min_y": -1,
                "max_y": 1,
            },
        },
    }
    out = bench.collect(LaserScan, "scan_filtered")
    start(bench, ScanFilterChainNode(bench.process, values))
    bench.publish(LaserScan, "scan", _scan())
    assert not out  # the laser's pose is not known yet
    _mount(bench, "laser")
    bench.publish(LaserScan, "scan", _scan())
    (got,) = out
    assert list(got.ranges) == pytest.approx([2.0, math.nan, 4.0, 5.0], nan_ok=True)
    assert list(got.intensities) == [2.0, 3.0, 4.0, 5.0]
    assert (got.angle_min, got.angle_max) == pytest.approx((-0.1, 0.2))
    assert got.header.stamp.nanosec == pytest.approx(10_000_000, abs=10)


def test_points_between_two_heights_are_a_scan(bench: RosBench) -> None:
    values = {"target_frame": "base_link", "min_height": 0.0, "max_height": 1.0, "range_max": 4.0}
    out = bench.collect(LaserScan, "scan")
    start(bench, PointcloudToLaserscanNode(bench.process, values))
    _mount(bench, "lidar")
    points = [
        (2.1, 0, 0),
        (1.1, 0, 0.1),
        (0.6, 0, 0.6),
        (0.1, -3, 0),
        (0.1, 5, 0),
        (math.nan, 0, 0),
    ]
    cloud = cloud_msg(np.array(points, np.float32), "lidar", 1.0)
    bench.publish(PointCloud2, "cloud_in", cloud)
    (got,) = out
    assert got.header.frame_id == "base_link"
    assert len(got.ranges) == 360
    found = {number: r for number, r in enumerate(got.ranges) if math.isfinite(r)}
    assert found == pytest.approx({180: 1.0, 90: 3.0})


def test_beams_without_a_point_are_infinite_or_beyond(bench: RosBench) -> None:
    out = bench.collect(LaserScan, "scan")
    values = {"use_inf": False, "inf_epsilon": 0.5, "range_max": 4.0}
    start(bench, PointcloudToLaserscanNode(bench.process, values))
    bench.publish(PointCloud2, "cloud_in", cloud_msg(np.zeros((0, 3), np.float32), "a", 1.0))
    assert set(out[0].ranges) == {4.5}


def test_a_scan_is_a_cloud(bench: RosBench) -> None:
    out = bench.collect(PointCloud2, "cloud")
    start(bench, LaserscanToPointcloudNode(bench.process, {"target_frame": "base_link"}))
    _mount(bench, "laser")
    message = _scan()
    message.ranges[0] = math.inf
    bench.publish(LaserScan, "scan_in", message)
    points = cloud_from_msg(out[0], Pose3()).points
    assert len(points) == 4
    np.testing.assert_allclose(points[1], (0.3, 0.0, 0.5), atol=1e-6)


@pytest.mark.parametrize("encoding", ["32FC1", "16UC1"])
def test_the_middle_rows_of_a_depth_image_are_a_scan(bench: RosBench, encoding: str) -> None:
    out = bench.collect(LaserScan, "scan")
    start(bench, DepthimageToLaserscanNode(bench.process, {"scan_height": 3, "range_max": 5.0}))
    camera = CameraInfo(k=[50.0, 0.0, 50.0, 0.0, 50.0, 10.0, 0.0, 0.0, 1.0])
    bench.publish(CameraInfo, "depth_camera_info", camera)
    depth = np.full((20, 101), 2.0)  # a wall across
    depth[9, 50] = 1.0
    depth[3, 50] = 0.6  # not one of the middle rows
    depth[:, 100] = 9.0
    raw = depth.astype("<f4") if encoding == "32FC1" else (depth * 1000).astype("<u2")
    image = Image(header=header("optical", 1.0), height=20, width=101, encoding=encoding)
    image.step, image.data = raw.strides[0], raw.tobytes()
    bench.publish(Image, "depth", image)
    (got,) = out
    assert got.header.frame_id == "camera_depth_frame"
    assert (got.angle_min, got.angle_max) == pytest.approx((-math.pi / 4, math.pi / 4))
    assert got.ranges[50] == pytest.approx(1.0)
    assert math.isnan(got.ranges[0])  # the right edge is out of range
    left = got.angle_min + 90 * got.angle_increment
    assert got.ranges[90] * math.cos(left) == pytest.approx(2.0, rel=0.01)


def _imu(stamp: float, yaw_rate: float = 0.0) -> Imu:
    message = Imu(header=header("imu_link", stamp))
    message.linear_acceleration.z, message.angular_velocity.z = 9.81, yaw_rate
    return message


def test_an_imu_gets_an_orientation(bench: RosBench) -> None:
    out, tf = bench.collect(Imu, "imu/data"), bench.collect(TFMessage, "/tf")
    values = {"use_mag": False, "remove_gravity_vector": True, "orientation_stddev": 0.1}
    start(bench, ImuFilterNode(bench.process, values))
    for step in range(101):
        bench.publish(Imu, "imu/data_raw", _imu(1.0 + 0.01 * step, 0.5))
    q = out[-1].orientation
    assert 2.0 * math.atan2(q.z, q.w) == pytest.approx(0.5, abs=0.01)
    assert out[-1].linear_acceleration.z == pytest.approx(0.0, abs=1e-6)
    assert out[-1].orientation_covariance[0] == pytest.approx(0.01)
    (T,) = tf[-1].transforms
    assert (T.header.frame_id, T.child_frame_id) == ("odom", "imu_link")


def test_a_compass_gives_the_heading(bench: RosBench) -> None:
    out = bench.collect(Imu, "imu/data")
    angles = bench.collect(Vector3Stamped, "imu/rpy/filtered")
    values = {"yaw_offset": 0.3, "declination": 0.1, "publish_debug_topics": True}
    start(bench, ImuFilterNode(bench.process, values | {"stateless": True, "publish_tf": False}))
    bench.publish(Imu, "imu/data_raw", _imu(1.0))
    assert not out
    field = MagneticField()
    field.magnetic_field.x, field.magnetic_field.z = 2e-5, -4e-5  # its x axis is to the north
    bench.publish(MagneticField, "imu/mag", field)
    bench.publish(Imu, "imu/data_raw", _imu(1.1))
    assert angles[0].vector.z == pytest.approx(math.pi / 2 + 0.2)


ARM = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base_link"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="fixed" type="fixed"><parent link="base_link"/><child link="d"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="a"/>
    <axis xyz="0 0 1"/><limit lower="1" upper="3" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="a"/><child link="b"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="finger" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
    <mimic joint="elbow" multiplier="-2" offset="0.5"/></joint>
</robot>"""


def _positions(message: Any) -> dict[str, float]:
    return dict(zip(message.name, message.position, strict=True))


def test_every_moving_joint_has_a_state(bench: RosBench) -> None:
    out = bench.collect(JointState, "joint_states")
    values = {"source_list": ["arm_states"], "rate": 10.0}
    start(bench, JointStatePublisherNode(bench.process, values))
    bench.advance(0.2)
    assert not out
    bench.publish(String, "robot_description", String(data=ARM), qos.LATCHED)
    bench.advance(0.2)
    assert _positions(out[-1]) == pytest.approx({"shoulder": 2.0, "elbow": 0.0, "finger": 0.5})
    assert not out[-1].velocity
    bench.publish(JointState, "arm_states", JointState(name=["elbow", "x"], position=[0.2, 9.0]))
    assert _positions(out[-1])["elbow"] == 0.0  # a source that is its own output does not run wild
    bench.advance(0.1)
    assert _positions(out[-1]) == pytest.approx({"shoulder": 2.0, "elbow": 0.2, "finger": 0.1})


@pytest.mark.parametrize("sliders", [False, True])
def test_the_view_s_sliders_are_a_source_of_the_gui_s(bench: RosBench, sliders: bool) -> None:
    out = bench.collect(JointState, "joint_states")
    values = {"robot_description": ARM, "sliders": sliders}
    start(bench, JointStatePublisherNode(bench.process, values))
    bench.publish(JointState, SLIDERS, JointState(name=["elbow"], position=[0.2]))
    bench.advance(0.2)
    assert _positions(out[-1])["elbow"] == (0.2 if sliders else 0.0)


def test_zeros_dependents_and_moving_joints(bench: RosBench) -> None:
    out = bench.collect(JointState, "joint_states")
    values = {
        "robot_description": ARM,
        "zeros": {"shoulder": 1.4},
        "dependent_joints": {"elbow": {"parent": "shoulder", "factor": 0.5}},
        "delta": 0.2,
        "publish_default_efforts": True,
    }
    start(bench, JointStatePublisherNode(bench.process, values))
    bench.advance(0.1)
    expected = {"shoulder": 1.6, "elbow": 0.8, "finger": -1.1}
    assert _positions(out[0]) == pytest.approx(expected)
    assert list(out[0].effort) == [0.0] * 3
    bench.advance(2.0)
    turned = [_positions(one)["shoulder"] for one in out]
    assert max(turned) == pytest.approx(3.0)
    assert turned[-1] < 3.0
