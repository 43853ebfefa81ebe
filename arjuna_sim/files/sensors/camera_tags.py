"""Reading a robot's cameras: their pictures, and the topics of colours, distances and points."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sensors.sensor_tags import frame_of, mount, place_of
from arjuna_sim.files.urdf.gazebo_text import plain, text_of, topic
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import TOPICS, CameraSettings

_PIXELS_MAX = 4096
_WIDEST = 2.8  # [rad]


def camera(xml: XmlFile, sensor: Element, link: str, depth: bool) -> CameraSettings:
    """Read a camera.

    Args:
        xml: The file.
        sensor: The `<sensor>`.
        link: The link that carries it.
        depth: Whether it tells distances.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    tag = sensor.find("camera")
    frame = text_of(sensor, "opticalframeid", default=frame_of(sensor, link)).lstrip("/")
    told = mount(xml, sensor, link, 30.0, TOPICS["camera"]) | {"frame": frame}
    settings = CameraSettings(
        **(told | _topics(sensor, depth)),
        width=xml.count(tag, "image/width", 640, place),
        height=xml.count(tag, "image/height", 480, place),
        horizontal_fov=_view(xml, tag, place),
        near=xml.number(tag, "clip/near", 0.05, place),
        far=xml.number(tag, "clip/far", 100.0, place),
        depth=depth,
    )
    if not (0 < settings.width <= _PIXELS_MAX and 0 < settings.height <= _PIXELS_MAX):
        size = f"{settings.width} x {settings.height}"
        raise xml.fail(place, f"image is {size}; valid: 1 to {_PIXELS_MAX} pixels")
    if not 0.0 < settings.near < settings.far:
        problem = f"<clip> {settings.near} to {settings.far} must be 0 < near < far"
        raise xml.fail(place, problem)
    return settings


def _view(xml: XmlFile, tag: Element | None, place: str) -> float:
    """Return the field of view; that of a fish-eye is cut to what a flat picture can hold [rad]."""
    angle = xml.number(tag, "horizontal_fov", 1.047, place)
    if not 0.0 < angle <= 2.0 * math.pi:
        raise xml.fail(place, f"<horizontal_fov> is {angle}; valid: above 0, up to 2 pi")
    if angle > _WIDEST:
        xml.note(f"{place}: <horizontal_fov> {angle:g} is cut to {_WIDEST:g}, as it has no lens")
    return min(angle, _WIDEST)


def _topics(sensor: Element, depth: bool) -> dict[str, str]:
    """Return the topics of colours, distances, points and the calibration.

    ROS plugins join `<camera>/<image>`; gz-sim makes all of them of one `<topic>`.
    """
    image = topic(sensor, "", "~/image_raw", "imagetopicname")
    name = text_of(sensor, "cameraname")
    own = next((c.text.strip() for c in sensor if plain(c.tag) == "topic" and c.text), "")
    info = text_of(sensor, "camerainfotopic") or (sensor.findtext("camera/camera_info_topic") or "")
    if own and not image:
        return _of_gz(sensor, own, depth) | ({"info_topic": info.strip()} if info else {})
    if not image and not name:
        return {"topic": TOPICS["camera"]} | ({"cloud_topic": "camera/points"} if depth else {})

    def joined(told: str, default: str) -> str:
        return told if told.startswith("/") or not name else f"{name}/{told or default}"

    found = {"topic": joined(image, "image_raw")}
    if depth:
        distances = topic(sensor, "", "~/depth/image_raw", "depthimagetopicname")
        points = topic(sensor, "", "~/points", "pointcloudtopicname")
        found |= {"depth_topic": joined(distances, "depth/image_raw")}
        found |= {"cloud_topic": joined(points, "points")}
    return found


def _of_gz(sensor: Element, own: str, depth: bool) -> dict[str, str]:
    """Return the topics that gz-sim makes of one."""
    if "rgbd" in plain(sensor.get("type", "")):
        names = {"topic": "image", "depth_topic": "depth_image", "cloud_topic": "points"}
        return {key: f"{own}/{name}" for key, name in names.items()} | {
            "info_topic": f"{own}/camera_info"
        }
    if not depth:
        return {"topic": own}
    return {"topic": f"{own}/image", "depth_topic": own, "cloud_topic": f"{own}/points"}
