"""Reading a robot's `<sensor>` tags: lidar, camera, depth camera and IMU."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.urdf.gazebo_text import plain, text_of, topic, value
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import TOPICS, CameraSettings, ImuSettings, LidarSettings

KINDS = {
    **dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), "lidar"),
    **dict.fromkeys(("camera", "wideanglecamera"), "camera"),
    **dict.fromkeys(("depth", "depth_camera", "rgbd_camera", "rgbd", "multicamera"), "depth"),
    "imu": "imu",
}
"""Types of sensors that are simulated, and as what."""
_RATE_MAX = 1000.0
_PIXELS_MAX = 4096
_BEAMS_MAX = 100_000
_RANGE_MAX = 10_000.0


def place_of(sensor: Element) -> str:
    """Return how messages call a sensor."""
    return f"sensor '{sensor.get('name') or sensor.get('type') or '?'}'"


def note_pose(xml: XmlFile, sensor: Element) -> None:
    """Note a sensor that stands off its link's origin."""
    words = (sensor.findtext("pose") or "").split()
    if any(xml.numbers(" ".join(words), len(words), f"{place_of(sensor)} pose")):
        xml.note(f"{place_of(sensor)}: its <pose> is left out: it sits at its link's origin")


def lidar(xml: XmlFile, sensor: Element, link: str) -> LidarSettings:
    """Read a lidar.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    ray = _first(sensor, "ray", "lidar")
    horizontal = None if ray is None else ray.find("scan/horizontal")
    samples = xml.count(horizontal, "samples", 360, place)
    angle_min = xml.number(horizontal, "min_angle", -math.pi, place)
    angle_max = xml.number(horizontal, "max_angle", math.pi, place)
    range_min = xml.number(ray, "range/min", 0.1, place)
    range_max = min(xml.number(ray, "range/max", 10.0, place), _RANGE_MAX)
    if not 1 <= samples <= _BEAMS_MAX:
        raise xml.fail(place, f"<samples> is {samples}; valid: 1 to {_BEAMS_MAX}")
    if not angle_min < angle_max and samples > 1:
        raise xml.fail(place, f"<min_angle> {angle_min} must be below <max_angle> {angle_max}")
    if not 0.0 <= range_min < range_max:
        raise xml.fail(place, f"<range> {range_min} to {range_max} must be 0 <= min < max")
    if ray is not None and xml.number(ray, "scan/vertical/samples", 1, place) > 1:
        xml.note(f"{place}: only the level plane is simulated of its vertical samples")
    return LidarSettings(
        link,
        _frame(sensor, link),
        samples,
        angle_min,
        angle_max,
        range_min,
        range_max,
        _rate(xml, sensor, 10.0, place),
        _noise(xml, sensor, ray, place),
        topic(sensor, TOPICS["lidar"], "~/out", "topicname", "topic"),
    )


def camera(xml: XmlFile, sensor: Element, link: str, depth: bool) -> CameraSettings:
    """Read a camera.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    tag = sensor.find("camera")
    frame = text_of(sensor, "opticalframeid", default=_frame(sensor, link)).lstrip("/")
    settings = CameraSettings(
        link,
        frame,
        xml.count(tag, "image/width", 640, place),
        xml.count(tag, "image/height", 480, place),
        xml.number(tag, "horizontal_fov", 1.047, place),
        xml.number(tag, "clip/near", 0.05, place),
        xml.number(tag, "clip/far", 100.0, place),
        _rate(xml, sensor, 30.0, place),
        _camera_topic(sensor),
        depth,
    )
    if not (0 < settings.width <= _PIXELS_MAX and 0 < settings.height <= _PIXELS_MAX):
        size = f"{settings.width} x {settings.height}"
        raise xml.fail(place, f"image is {size}; valid: 1 to {_PIXELS_MAX} pixels")
    if not 0.0 < settings.horizontal_fov < math.pi:
        problem = f"<horizontal_fov> is {settings.horizontal_fov}; valid: above 0, below pi"
        raise xml.fail(place, problem)
    if not 0.0 < settings.near < settings.far:
        problem = f"<clip> {settings.near} to {settings.far} must be 0 < near < far"
        raise xml.fail(place, problem)
    return settings


def imu(xml: XmlFile, sensor: Element, link: str) -> ImuSettings:
    """Read an IMU.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    name = topic(sensor, TOPICS["imu"], "~/out", "topicname", "topic")
    return ImuSettings(link, _frame(sensor, link), _rate(xml, sensor, 50.0, place), name)


def imu_plugin(xml: XmlFile, plugin: Element) -> ImuSettings:
    """Read an IMU that a ROS 1 plugin attaches to a link without a sensor.

    Raises:
        RobotError: The rate is invalid.
    """
    place, link = f"plugin '{plugin.get('name', '?')}'", text_of(plugin, "bodyname", "bodyid")
    rate = value(xml, plugin, place, 50.0, "updaterate")
    if rate > _RATE_MAX:
        raise xml.fail(place, f"<updateRate> is {rate}; valid: up to {_RATE_MAX:g} Hz")
    frame = text_of(plugin, "frameid", "framename", default=link).lstrip("/")
    return ImuSettings(link, frame, rate, topic(plugin, TOPICS["imu"], "~/out", "topicname"))


def _first(element: Element, *tags: str) -> Element | None:
    return next((found for tag in tags if (found := element.find(tag)) is not None), None)


def _frame(sensor: Element, link: str) -> str:
    names = ("framename", "gzframeid", "ignitionframeid")
    return text_of(sensor, *names, default=link).lstrip("/")


def _rate(xml: XmlFile, sensor: Element, default: float, place: str) -> float:
    rate = xml.number(sensor, "update_rate", default, place)
    if not 0.0 <= rate <= _RATE_MAX:
        raise xml.fail(place, f"<update_rate> is {rate}; valid: above 0, up to {_RATE_MAX:g} Hz")
    if rate == 0.0:
        xml.note(f"{place}: <update_rate> 0 is taken as {default:g} Hz")
    return rate or default


def _noise(xml: XmlFile, sensor: Element, ray: Element | None, place: str) -> float:
    """Return the standard deviation of a lidar's ranges: its own, else its plugin's [m]."""
    noise = xml.number(ray, "noise/stddev", xml.number(sensor, "noise/stddev", 0.0, place), place)
    if noise == 0.0 and (text := text_of(sensor, "gaussiannoise")):
        noise = xml.numbers(text, 1, f"{place} <gaussianNoise>")[0]
    if noise < 0.0:
        raise xml.fail(place, f"<stddev> is {noise}; it must not be negative")
    return noise


def _camera_topic(sensor: Element) -> str:
    """Return `<camera>/<image>`, as the camera plugins join them."""
    image = topic(sensor, "", "~/image_raw", "imagetopicname")
    name = text_of(sensor, "cameraname")
    own = [child.text for child in sensor if plain(child.tag) == "topic" and child.text]
    if own and not image:
        return own[0].strip()
    if not image and not name:
        return TOPICS["camera"]
    return image if image.startswith("/") or not name else f"{name}/{image or 'image_raw'}"
