"""sensor_msgs_py, laser_geometry and tf2_sensor_msgs: clouds as students' scripts use them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import tf2_ros
from geometry_msgs.msg import TransformStamped
from laser_geometry import LaserProjection
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from sensor_msgs_py import point_cloud2
from std_msgs.msg import Header
from tf2_sensor_msgs import do_transform_cloud, transform_points

NAMES = ("x", "y", "z")
RGB = [
    *(
        PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1)
        for i, n in enumerate(NAMES)
    ),
    PointField(name="rgb", offset=16, datatype=PointField.UINT32, count=1),
]


def test_points_are_read_as_they_were_written() -> None:
    header = Header(frame_id="camera")
    points = [(1.0, 2.0, 3.0, 255), (4.0, 5.0, math.nan, 7)]
    cloud = point_cloud2.create_cloud(header, RGB, points, point_step=32)
    assert (cloud.width, cloud.height, cloud.point_step, cloud.row_step) == (2, 1, 32, 64)
    got = point_cloud2.read_points(cloud)
    assert got.dtype.names == ("x", "y", "z", "rgb")
    assert got["rgb"].tolist() == [255, 7]
    assert len(point_cloud2.read_points(cloud, skip_nans=True)) == 1
    plain = point_cloud2.read_points_numpy(cloud, field_names=("y", "x"), uvs=[1])
    np.testing.assert_array_equal(plain, [[5.0, 4.0]])
    listed = point_cloud2.read_points_list(cloud, field_names=NAMES, skip_nans=True)
    assert (listed[0].x, listed[0].z) == (1.0, 3.0)


def test_organized_big_endian_and_padded_clouds_are_read() -> None:
    grid = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
    cloud = point_cloud2.create_cloud_xyz32(Header(), grid)
    assert (cloud.height, cloud.width) == (2, 3)
    np.testing.assert_array_equal(point_cloud2.read_points_numpy(cloud), grid.reshape(6, 3))
    chosen = point_cloud2.read_points_numpy(cloud, NAMES, uvs=[(2, 1)])
    np.testing.assert_array_equal(chosen, [[15.0, 16.0, 17.0]])
    big = PointCloud2(height=2, width=3, fields=cloud.fields, is_bigendian=True)
    big.point_step, big.row_step = 12, 40
    rows = grid.astype(">f4").reshape(2, 9)
    big.data = b"".join(row.tobytes() + b"\xff" * 4 for row in rows)
    np.testing.assert_array_equal(point_cloud2.read_points_numpy(big), grid.reshape(6, 3))


def test_fields_of_several_types_are_no_plain_array() -> None:
    cloud = point_cloud2.create_cloud(Header(), RGB, [(0.0, 0.0, 0.0, 1)])
    with pytest.raises(AssertionError, match="same datatype"):
        point_cloud2.read_points_numpy(cloud)


def test_a_scan_is_projected_with_its_channels() -> None:
    scan = LaserScan(angle_min=0.0, angle_increment=math.pi / 2, range_min=0.5, range_max=5.0)
    scan.ranges, scan.intensities = [1.0, 0.1, 2.0, 9.0, math.nan], [10.0, 20.0, 30.0, 40.0, 50.0]
    scan.time_increment = 0.5
    project = LaserProjection().projectLaser
    got = point_cloud2.read_points(project(scan))
    assert got.dtype.names == ("x", "y", "z", "intensity", "index")
    np.testing.assert_allclose(got["x"], [1.0, -2.0], atol=1e-6)
    assert got["index"].tolist() == [0, 2]
    assert got["intensity"].tolist() == [10.0, 30.0]
    option = LaserProjection.ChannelOption
    got = point_cloud2.read_points(project(scan, 1.5, option.DISTANCE | option.TIMESTAMP))
    assert got.dtype.names == ("x", "y", "z", "distances", "stamps")
    assert len(got) == 1


def test_a_cloud_is_transformed_with_its_normals_and_other_fields() -> None:
    transform = TransformStamped(header=Header(frame_id="map"))
    transform.transform.translation.x = 1.0
    transform.transform.rotation.z = transform.transform.rotation.w = math.sqrt(0.5)
    names = ("x", "y", "z", "normal_x", "normal_y", "normal_z", "ring")
    fields = [
        PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1)
        for i, n in enumerate(names)
    ]
    cloud = point_cloud2.create_cloud(Header(frame_id="a"), fields, [(1, 2, 3, 1, 0, 0, 7)])
    expected = [[-1.0, 1.0, 3.0, 0.0, 1.0, 0.0, 7.0]]
    moved = do_transform_cloud(cloud, transform)
    assert moved.header.frame_id == "map"
    np.testing.assert_allclose(point_cloud2.read_points_numpy(moved), expected, atol=1e-6)
    registered = tf2_ros.TransformRegistration().get(PointCloud2)
    assert registered is do_transform_cloud
    points = transform_points(np.array([[1.0, 2.0, 3.0]]), transform.transform)
    np.testing.assert_allclose(points, [[-1.0, 1.0, 3.0]], atol=1e-12)
