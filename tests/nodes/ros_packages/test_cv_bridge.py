"""cv_bridge and sensor_msgs_py: images and clouds as arrays."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import tf2_ros
from cv_bridge import CvBridge, CvBridgeError
from geometry_msgs.msg import TransformStamped
from image_geometry import PinholeCameraModel
from laser_geometry import LaserProjection
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, LaserScan, PointCloud2, PointField
from sensor_msgs_py import point_cloud2
from std_msgs.msg import Header
from tf2_sensor_msgs import do_transform_cloud, transform_points

BRIDGE = CvBridge()
COLOURS = np.array([[[10, 20, 30], [200, 100, 0]]], np.uint8)  # blue, green, red


@pytest.mark.parametrize(
    "dtype", ["uint8", "int8", "uint16", "int16", "int32", "float32", "float64"]
)
@pytest.mark.parametrize("channels", [None, 1, 2, 3, 4])
def test_arrays_of_every_type_come_back(dtype: str, channels: int | None) -> None:
    shape = (3, 5) if channels is None else (3, 5, channels)
    given = np.arange(math.prod(shape)).reshape(shape).astype(dtype)
    message = BRIDGE.cv2_to_imgmsg(given, header=Header(frame_id="camera"))
    assert message.header.frame_id == "camera"
    assert message.step * message.height == given.nbytes
    got = BRIDGE.imgmsg_to_cv2(message)
    assert got.dtype == given.dtype
    np.testing.assert_array_equal(got, given[:, :, 0] if channels == 1 else given)


def test_colours_are_converted_as_opencv_does() -> None:
    message = BRIDGE.cv2_to_imgmsg(COLOURS, "bgr8")

    def got(encoding: str) -> Any:
        return BRIDGE.imgmsg_to_cv2(message, encoding).tolist()

    assert got("rgb8") == [[[30, 20, 10], [0, 100, 200]]]
    assert got("mono8") == [[22, 82]]  # 0.299 R + 0.587 G + 0.114 B
    assert got("rgba8") == [[[30, 20, 10, 255], [0, 100, 200, 255]]]
    assert got("bgr16")[0][0] == [2570, 5140, 7710]
    grey = BRIDGE.cv2_to_imgmsg(np.array([[7]], np.uint8), "mono8")
    assert BRIDGE.imgmsg_to_cv2(grey, "bgr8").tolist() == [[[7, 7, 7]]]
    deep = BRIDGE.cv2_to_imgmsg(np.array([[514]], np.uint16), "mono16")
    assert BRIDGE.imgmsg_to_cv2(deep, "mono8").tolist() == [[2]]


def test_rows_with_something_behind_and_big_endian_depths_are_read() -> None:
    message = Image(height=2, width=2, encoding="16UC1", is_bigendian=1, step=6)
    message.data = b"\x00\x01\x00\x02\xff\xff\x01\x00\x02\x00\xff\xff"
    assert BRIDGE.imgmsg_to_cv2(message).tolist() == [[1, 2], [256, 512]]


def test_what_has_no_conversion_is_refused() -> None:
    message = BRIDGE.cv2_to_imgmsg(COLOURS, "bgr8")
    with pytest.raises(CvBridgeError, match="no encoding 'pink'; valid: mono8"):
        BRIDGE.imgmsg_to_cv2(message, "pink")
    with pytest.raises(CvBridgeError, match="encoding specified as mono8, but image has type 8UC3"):
        BRIDGE.cv2_to_imgmsg(COLOURS, "mono8")
    with pytest.raises(TypeError, match="not a numpy array"):
        BRIDGE.cv2_to_imgmsg([[1]])  # type: ignore[arg-type]
    with pytest.raises(CvBridgeError, match="no conversion from 32FC2 to bgr8"):
        BRIDGE.imgmsg_to_cv2(BRIDGE.cv2_to_imgmsg(np.zeros((1, 1, 2), np.float32)), "bgr8")


@pytest.mark.parametrize("name", ["png", "jpg"])
def test_compressed_images_come_back(name: str) -> None:
    wide = np.repeat(np.repeat(COLOURS, 16, 0), 16, 1)
    message = BRIDGE.cv2_to_compressed_imgmsg(wide, name)
    assert message.format == name
    got = BRIDGE.compressed_imgmsg_to_cv2(message)
    inside = slice(0, 8)  # a JPEG's colours run together at edges
    tolerance = 0 if name == "png" else 3
    np.testing.assert_allclose(got[:, inside], wide[:, inside], atol=tolerance)
    np.testing.assert_allclose(
        BRIDGE.compressed_imgmsg_to_cv2(message, "rgb8"), got[:, :, ::-1], atol=1
    )
    grey = BRIDGE.cv2_to_compressed_imgmsg(np.full((2, 2), 9, np.uint8), name)
    assert BRIDGE.compressed_imgmsg_to_cv2(grey, "mono8").tolist() == [[9, 9], [9, 9]]


def test_bytes_that_are_no_picture_are_refused() -> None:
    with pytest.raises(CvBridgeError, match="'jpeg': cannot identify"):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage(format="jpeg", data=b"nothing"))


def test_opencvs_numbers_of_types() -> None:
    assert BRIDGE.encoding_to_cvtype2("bgr8") == 16  # CV_8UC3
    assert BRIDGE.encoding_to_cvtype2("32FC1") == 5
    assert BRIDGE.cvtype2_to_dtype_with_channels(18) == ("uint16", 3)


def test_points_and_pixels_of_a_camera() -> None:
    info = CameraInfo(width=640, height=480)
    info.header.frame_id = "optical"
    info.p = [500.0, 0.0, 320.0, -50.0, 0.0, 400.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    camera = PinholeCameraModel()
    camera.from_camera_info(info)
    assert camera.project_3d_to_pixel((0.2, 0.1, 2.0)) == pytest.approx((345.0, 260.0))
    x, y, z = camera.projectPixelTo3dRay((345.0, 260.0))
    assert (x / z * 2.0, y / z * 2.0) == pytest.approx((0.3, 0.1))  # of the left camera's
    assert camera.get_delta_u(0.1, 2.0) == pytest.approx(25.0)
    assert camera.tf_frame == "optical"
    info.binning_x = info.binning_y = 2
    info.roi.x_offset = 20
    camera.fromCameraInfo(info)
    assert (camera.fx(), camera.cx()) == (250.0, 150.0)


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


def test_programs_of_jazzy_s_opencv_find_its_markers_functions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    aruco = SimpleNamespace(
        getPredefinedDictionary=lambda number: ("dictionary", number),
        DetectorParameters=lambda: "parameters",
        ArucoDetector=lambda *given: SimpleNamespace(detectMarkers=lambda image: (image, given)),
        generateImageMarker="marker",
    )
    opencv = SimpleNamespace(
        aruco=aruco,
        drawFrameAxes="axes",
        solvePnP=lambda points, corners, *camera: (True, points[0], corners[0][0]),
    )
    monkeypatch.setitem(sys.modules, "cv2", opencv)
    CvBridge()
    functions: Any = aruco
    dictionary = functions.Dictionary_get(7)
    asked = functions.DetectorParameters_create()
    assert functions.detectMarkers("image", dictionary, parameters=asked) == (
        "image",
        (("dictionary", 7), "parameters"),
    )
    corners = [np.full((1, 4, 3), float(i)) for i in (1, 2)]
    turned, moved, points = functions.estimatePoseSingleMarkers(corners, 0.2, "K", "D")
    square = [(-0.1, 0.1, 0.0), (0.1, 0.1, 0.0), (0.1, -0.1, 0.0), (-0.1, -0.1, 0.0)]
    np.testing.assert_allclose(points[:, 0], square, atol=1e-6)
    assert (turned.shape, moved.shape) == ((2, 1, 3), (2, 1, 3))
    assert (functions.drawAxis, functions.drawMarker) == ("axes", "marker")


def test_an_opencv_keeps_its_own_markers_functions(monkeypatch: pytest.MonkeyPatch) -> None:
    own = SimpleNamespace(
        **dict.fromkeys(("getPredefinedDictionary", "DetectorParameters", "ArucoDetector")),
        generateImageMarker=None,
        detectMarkers="own",
    )
    monkeypatch.setitem(sys.modules, "cv2", SimpleNamespace(aruco=own, drawFrameAxes=None))
    CvBridge()
    assert own.detectMarkers == "own"
