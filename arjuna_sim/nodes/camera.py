"""The camera's topics: pictures are drawn only while someone looks."""

from __future__ import annotations

import array
import io
from functools import partial
from typing import Any

import numpy as np
import PIL.Image
from geometry_msgs.msg import Twist
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2
from std_msgs.msg import Float64

from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_msg, header, velocity_from_twist
from arjuna_core.ros.node import ManagedNode
from arjuna_core.timing import Periodic
from arjuna_sim.devices.camera import CameraError, CameraThread, Shot, focal_length, points
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.world import World
from arjuna_sim.nodes.sensor_topics import SensorTopics
from arjuna_sim.physics.stage import Stage
from arjuna_sim.staged_sensors import StagedSensors

_QUALITY = 95  # of JPEG, as image_transport's


class WorldTopics:
    """Publishes the sensors of the world that is there, and takes its movers' commands.

    Topics of a world that was there before stay, silent, until the node's cleanup.
    """

    def __init__(self, node: ManagedNode, fixed: StagedSensors, stage: Stage) -> None:
        self._node, self._fixed, self._stage = node, fixed, stage
        self._world: World | None = None
        self._cameras: list[CameraTopics] = []
        self._commands: list[Any] = []
        self.follow()

    def publish(self, now: float, interactive: bool) -> None:
        """Publish what is due at a time [s] and subscribed to, as robots' interfaces do."""
        self._topics.publish(now)
        for camera in self._cameras:
            camera.publish(now, interactive)

    def follow(self) -> None:
        """Serve another world, where that has been loaded."""
        if self._stage.world is self._world:
            return
        self.close()
        self._world, sensors, node = self._stage.world, self._fixed.settings, self._node
        self._topics = SensorTopics(node, self._fixed, sensors)
        lenses = [each for each in sensors if isinstance(each, CameraSettings)]
        self._cameras = [CameraTopics(node, self._fixed, self._stage, each) for each in lenses]
        for subscription in self._commands:
            node.unsubscribe(subscription)
        self._commands = [
            node.subscribe(Twist, mover.topic, partial(self._command, name), qos.LATEST)
            for name, mover in self._world.movers.items()
        ]
        self._commands += [
            node.subscribe(Float64, motor.topic, partial(self._turn, name), qos.LATEST)
            for name, motor in self._world.motors.items()
        ]

    def _command(self, name: str, message: Twist) -> None:
        self._stage.movers.command(name, velocity_from_twist(message))

    def _turn(self, name: str, message: Float64) -> None:
        self._stage.movers.motors.command(name, message.data)

    def close(self) -> None:
        """End drawing beside the physics."""
        for camera in self._cameras:
            camera.close()


class CameraTopics:
    """Publishes a camera's colours, distances and points, and a `camera_info` beside each picture.

    In lock-step a picture is drawn at its tick, the same each time; in real time it is drawn
    beside the physics, published when it is done, and left out where drawing is too slow.

    Args:
        cloud_rate: Most clouds a second while nobody looks at pictures, 0 for all [Hz].
    """

    def __init__(
        self,
        node: ManagedNode,
        robot: StagedSensors,
        stage: Stage,
        settings: CameraSettings,
        cloud_rate: float = 0.0,
    ) -> None:
        self._log = node.get_logger()
        self._robot, self._stage = robot, stage
        self._settings = settings
        depth = settings.depth_topic or beside(settings.topic, "depth/image_raw")
        info = settings.info_topic or beside(settings.topic, "camera_info")
        self._image_out = node.publisher(Image, settings.topic, qos.SENSOR_PUBLISHER)
        compressed = f"{settings.topic}/compressed"
        self._jpeg_out = node.publisher(CompressedImage, compressed, qos.SENSOR_PUBLISHER)
        self._info_out = node.publisher(CameraInfo, info, qos.SENSOR_PUBLISHER)
        self._depth_out = node.publisher(Image, depth, qos.SENSOR_PUBLISHER)
        infos = [self._info_out]
        if beside(depth, "camera_info") != info:
            depth_info = beside(depth, "camera_info")
            infos.append(node.publisher(CameraInfo, depth_info, qos.SENSOR_PUBLISHER))
        self._infos = infos
        self._cloud_out = None
        if settings.cloud_topic:
            cloud = settings.cloud_topic
            self._cloud_out = node.publisher(PointCloud2, cloud, qos.SENSOR_PUBLISHER)
        self._due = Periodic(1.0 / settings.rate, phase=1.0 / settings.rate)
        period = 1.0 / min(settings.rate, cloud_rate or settings.rate)
        self._cloud_due = Periodic(period, phase=period)
        self._works = True
        self._thread: CameraThread | None = None

    def publish(self, now: float, interactive: bool) -> None:
        """Publish what is due [s] and subscribed to; `interactive`: drawing may take no time."""
        if self._thread is not None and (done := self._thread.take()) is not None:
            self._finish(*done)
        if not self._due.due(now):
            return
        for out in self._infos:
            if out.get_subscription_count() > 0:
                out.publish(camera_info(self._settings, now))
        outs = self._image_out, self._jpeg_out
        color = any(out.get_subscription_count() > 0 for out in outs)
        depth = self._depth_out.get_subscription_count() > 0
        depth = (self._gives_points() and self._cloud_due.due(now)) or depth
        if self._works and (color or depth):
            if interactive:
                self._ask(now, color, depth)
            else:
                self._shoot(now, color, depth)

    def _gives_points(self) -> bool:
        return self._cloud_out is not None and self._cloud_out.get_subscription_count() > 0

    def _ask(self, now: float, color: bool, depth: bool) -> None:
        if self._thread is None:
            staged = self._robot.staged(self._settings)
            self._thread = CameraThread(staged, self._robot.seed)
        self._thread.ask(self._stage.scene.model, self._stage.data, now, color, depth)

    def _shoot(self, now: float, color: bool, depth: bool) -> None:
        try:
            shot: Shot | CameraError = self._robot.picture(self._settings, color, depth)
        except CameraError as error:
            shot = error
        self._finish(now, shot)

    def _finish(self, stamp: float, shot: Shot | CameraError) -> None:
        if isinstance(shot, CameraError):
            self._works = False
            self._log.error(f"the camera stays off: {shot}")
            return
        if shot.color is not None:
            if self._image_out.get_subscription_count() > 0:
                encoding = self._settings.encoding
                written = colours_as(encoding, shot.color)
                self._image_out.publish(self._image(stamp, encoding, written))
            if self._jpeg_out.get_subscription_count() > 0:
                self._jpeg_out.publish(self._jpeg(stamp, shot.color))
        if shot.depth is not None:
            self._depth_out.publish(self._image(stamp, "32FC1", shot.depth))
            if self._cloud_out is not None and self._gives_points():
                seen = points(self._settings, shot.depth)
                self._cloud_out.publish(cloud_msg(seen, self._settings.frame, stamp))

    def _image(self, stamp: float, encoding: str, pixels: Any) -> Image:
        data = pixels.tobytes()
        return Image(
            header=header(self._settings.frame, stamp),
            height=pixels.shape[0],
            width=pixels.shape[1],
            encoding=encoding,
            step=len(data) // pixels.shape[0],
            data=array.array("B", data),
        )

    def _jpeg(self, stamp: float, pixels: Any) -> CompressedImage:
        file, encoding = io.BytesIO(), self._settings.encoding
        is_grey = encoding == "mono8"
        picture = PIL.Image.fromarray(colours_as(encoding, pixels) if is_grey else pixels)
        picture.save(file, "JPEG", quality=_QUALITY)
        inside = "mono8" if is_grey else "bgr8"
        return CompressedImage(
            header=header(self._settings.frame, stamp),
            format=f"{encoding}; jpeg compressed {inside}",  # as image_transport writes it
            data=array.array("B", file.getvalue()),
        )

    def close(self) -> None:
        """End drawing beside the physics."""
        if self._thread is not None:
            self._thread.close()
            self._thread = None


def colours_as(encoding: str, pixels: Any) -> Any:
    """Return red, green and blue, shape (height, width, 3), as an encoding writes them."""
    if encoding == "mono8":
        return np.asarray(PIL.Image.fromarray(pixels).convert("L"))
    return pixels[..., ::-1] if encoding == "bgr8" else pixels


def beside(topic: str, name: str) -> str:
    """Return a topic in the same namespace as another."""
    base = topic.rpartition("/")[0]
    return f"{base}/{name}" if base else name


def camera_info(settings: CameraSettings, now: float) -> CameraInfo:
    """Return the calibration of a pinhole camera and its lens at a time [s]."""
    f, cx, cy = focal_length(settings), settings.width / 2, settings.height / 2
    return CameraInfo(
        header=header(settings.frame, now),
        height=settings.height,
        width=settings.width,
        distortion_model="plumb_bob",
        d=settings.distortion or [0.0] * 5,
        k=[f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[f, 0.0, cx, 0.0, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    )
