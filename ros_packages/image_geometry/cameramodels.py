"""PinholeCameraModel: between pixels of a rectified image and rays of its camera."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

Array = NDArray[np.float64]


class PinholeCameraModel:
    """A camera without distortion, as its CameraInfo has it; OpenCV rectifies what is distorted."""

    def __init__(self) -> None:
        self.K: Array = np.eye(3)
        self.R: Array = np.eye(3)
        self.P: Array = np.eye(3, 4)
        self.D: Array = np.zeros(0)
        self.width = self.height = 0
        self.tf_frame, self.stamp = "", None

    def from_camera_info(self, msg: CameraInfo) -> None:
        """Take a camera's matrices, those of its binned and cut image."""
        self.K, self.R = np.reshape(msg.k, (3, 3)).copy(), np.reshape(msg.r, (3, 3)).copy()
        self.P, self.D = np.reshape(msg.p, (3, 4)).copy(), np.array(msg.d)
        self.width, self.height = msg.width, msg.height
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        for matrix in (self.K, self.P):
            matrix[0, 2] -= msg.roi.x_offset
            matrix[1, 2] -= msg.roi.y_offset
            matrix[0] /= self.binning_x
            matrix[1] /= self.binning_y

    def project_3d_to_pixel(self, point: Any) -> tuple[float, float]:
        """Return the column and row of a point of the camera's frame; NaN at depth 0."""
        u, v, w = self.P @ np.array((*point, 1.0))
        return (u / w, v / w) if w != 0.0 else (math.nan, math.nan)

    def project_pixel_to_3d_ray(self, uv: Any) -> tuple[float, float, float]:
        """Return the unit vector to what a rectified pixel shows."""
        x = (uv[0] - self.cx() - self.tx()) / self.fx() if self.fx() else 0.0
        y = (uv[1] - self.cy() - self.ty()) / self.fy() if self.fy() else 0.0
        length = math.sqrt(x * x + y * y + 1.0)
        return x / length, y / length, 1.0 / length

    def get_delta_u(self, delta_x: float, z: float) -> float:
        """Return how many columns a length [m] at a depth [m] is."""
        return math.inf if z == 0.0 else self.fx() * delta_x / z

    def get_delta_v(self, delta_y: float, z: float) -> float:
        """Return how many rows a length [m] at a depth [m] is."""
        return math.inf if z == 0.0 else self.fy() * delta_y / z

    def get_delta_x(self, delta_u: float, z: float) -> float:
        """Return the length [m] of columns at a depth [m]."""
        return z * delta_u / self.fx()

    def get_delta_y(self, delta_v: float, z: float) -> float:
        """Return the length [m] of rows at a depth [m]."""
        return z * delta_v / self.fy()

    def rectify_point(self, uv_raw: Any) -> Any:
        """Return where a raw pixel is in the rectified image."""
        import cv2

        source = np.array([[uv_raw]], np.float64)
        return cv2.undistortPoints(source, self.K, self.D, R=self.R, P=self.P)[0, 0]

    def rectify_image(self, raw: Any, rectified: Any) -> None:
        """Write the rectified image of a raw one into an array."""
        import cv2

        size = (self.width, self.height)
        maps = cv2.initUndistortRectifyMap(
            self.K, self.D, self.R, self.P[:, :3], size, cv2.CV_32FC1
        )
        cv2.remap(raw, *maps, cv2.INTER_CUBIC, rectified)

    def full_resolution(self) -> tuple[int, int]:
        return self.width, self.height

    def fx(self) -> float:
        """Return the focal length across [pixel]."""
        return float(self.P[0, 0])

    def fy(self) -> float:
        """Return the focal length down [pixel]."""
        return float(self.P[1, 1])

    def cx(self) -> float:
        """Return the column of the optical axis."""
        return float(self.P[0, 2])

    def cy(self) -> float:
        """Return the row of the optical axis."""
        return float(self.P[1, 2])

    def tx(self) -> float:
        """Return the baseline's part across [pixel m]."""
        return float(self.P[0, 3])

    def ty(self) -> float:
        """Return the baseline's part down [pixel m]."""
        return float(self.P[1, 3])

    def get_tf_frame(self) -> str:
        return self.tf_frame

    # the names of before Jazzy
    fromCameraInfo = from_camera_info
    project3dToPixel = project_3d_to_pixel
    projectPixelTo3dRay = project_pixel_to_3d_ray
    getDeltaU, getDeltaV = get_delta_u, get_delta_v
    getDeltaX, getDeltaY = get_delta_x, get_delta_y
    rectifyPoint, rectifyImage = rectify_point, rectify_image
    fullResolution, tfFrame, Tx, Ty = full_resolution, get_tf_frame, tx, ty
