"""The camera's topics: pictures are drawn only while someone looks."""

from __future__ import annotations

import array
from typing import TYPE_CHECKING

from sensor_msgs.msg import CameraInfo, Image

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.timing import Periodic
from arjuna_sim.camera import CameraError, focal_length
from arjuna_sim.gazebo import CameraSettings

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode


class CameraTopics:
    """Publishes `camera/image_raw` and `camera/camera_info`.

    Args:
        node: The simulator's node, being configured.
        settings: The camera.
    """

    def __init__(self, node: SimNode, settings: CameraSettings) -> None:
        self._node = node
        self._settings = settings
        self._image_out = node.publisher(Image, "camera/image_raw", qos.SENSOR_PUBLISHER)
        self._info_out = node.publisher(CameraInfo, "camera/camera_info", qos.SENSOR_PUBLISHER)
        self._due = Periodic(1.0 / settings.rate, phase=1.0 / settings.rate)
        self._works = True

    def publish(self, now: float) -> None:
        """Publish what is due at a time [s] and subscribed to."""
        if not self._due.due(now):
            return
        if self._info_out.get_subscription_count() > 0:
            self._info_out.publish(camera_info(self._settings, now))
        if self._works and self._image_out.get_subscription_count() > 0:
            self._publish_image(now)

    def _publish_image(self, now: float) -> None:
        try:
            picture = self._node.simulator.picture()
        except CameraError as error:
            self._works = False
            self._node.get_logger().error(f"the camera stays off: {error}")
            return
        height, width, _ = picture.shape
        self._image_out.publish(
            Image(
                header=header(self._settings.frame, now),
                height=height,
                width=width,
                encoding="rgb8",
                step=3 * width,
                data=array.array("B", picture.tobytes()),
            )
        )


def camera_info(settings: CameraSettings, now: float) -> CameraInfo:
    """Return the calibration of an ideal pinhole camera at a time [s]."""
    f, cx, cy = focal_length(settings), settings.width / 2, settings.height / 2
    return CameraInfo(
        header=header(settings.frame, now),
        height=settings.height,
        width=settings.width,
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=[f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[f, 0.0, cx, 0.0, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )
