"""cv_bridge and image_geometry: images and pixels as students' scripts use them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from cv_bridge import CvBridge, CvBridgeError
from image_geometry import PinholeCameraModel
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

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
