"""Reading a URDF's Gazebo tags: the drive, the sensors and the friction, as typed settings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_sim.shapes import Kind
from arjuna_sim.urdf import Urdf
from arjuna_sim.xml_file import XmlFile

_LEFT = ("leftfrontjoint", "leftrearjoint", "leftmiddlejoint", "leftjoint")
_RIGHT = ("rightfrontjoint", "rightrearjoint", "rightmiddlejoint", "rightjoint")
_LIDARS = ("ray", "gpu_ray", "lidar", "gpu_lidar")
_SENSORS = (*_LIDARS, "camera", "imu")
_TORQUE = 5.0  # [N m] where the plugin names none


@dataclass(frozen=True)
class DriveSettings:
    """A skid-steer or differential drive.

    Attributes:
        left: Names of the left wheels' joints.
        right: Names of the right wheels' joints.
        separation: Distance between left and right wheels [m].
        radius: Wheels' radius [m].
        torque: Greatest torque of each wheel [N m].
        effective_track: Track of the two-wheeled robot that turns like this one [m].
        effective_radius: Radius that makes wheel turns into distance [m].
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    radius: float
    torque: float
    effective_track: float
    effective_radius: float


@dataclass(frozen=True)
class LidarSettings:
    """A planar lidar: angles [rad], ranges [m], rate [Hz], standard deviation of noise [m]."""

    link: str
    frame: str
    samples: int
    angle_min: float
    angle_max: float
    range_min: float
    range_max: float
    rate: float
    noise: float


@dataclass(frozen=True)
class CameraSettings:
    """A colour camera: size [pixels], field of view [rad], clip distances [m], rate [Hz]."""

    link: str
    frame: str
    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float
    rate: float


@dataclass(frozen=True)
class ImuSettings:
    """An IMU: rate [Hz]."""

    link: str
    frame: str
    rate: float


@dataclass(frozen=True)
class GazeboSettings:
    """All that the Gazebo tags say and the simulation understands."""

    drive: DriveSettings | None
    lidar: LidarSettings | None
    camera: CameraSettings | None
    imu: ImuSettings | None
    friction: dict[str, float]


def read_gazebo(xml: XmlFile, urdf: Urdf) -> GazeboSettings:
    """Read drive, sensors and friction; what is not understood becomes a note.

    Raises:
        RobotError: A tag names a joint or link that does not exist, or a value is invalid.
    """
    drive = None
    friction = {}
    sensors: dict[str, tuple[Element, str]] = {}
    for gazebo in xml.root.findall("gazebo"):
        link = gazebo.get("reference")
        if link is not None and link not in urdf.links and link not in urdf.joints:
            problem = f"reference '{link}' does not exist; {nearest(link, urdf.links)}"
            raise xml.fail("gazebo", problem)
        for plugin in gazebo.findall("plugin"):
            drive = _drive(xml, plugin, urdf) or drive
        mu = gazebo.findtext("mu1")
        if link is not None and mu is not None:
            friction[link] = max(0.0, xml.numbers(mu, 1, f"gazebo '{link}' mu1")[0])
        for sensor in gazebo.findall("sensor"):
            _sort_sensor(xml, sensor, link or urdf.root, sensors)
    return GazeboSettings(
        drive,
        _lidar(xml, *sensors["lidar"]) if "lidar" in sensors else None,
        _camera(xml, *sensors["camera"]) if "camera" in sensors else None,
        _imu(xml, *sensors["imu"]) if "imu" in sensors else None,
        friction,
    )


def _plain(tag: str) -> str:
    """Drop what the Gazebo versions spell differently."""
    return tag.replace("_", "").lower()


def _texts(element: Element, *names: str) -> Iterator[str]:
    """Yield the texts of all descendants of one of these plain names."""
    for child in element.iter():
        if _plain(child.tag) in names and child.text and child.text.strip():
            yield child.text.strip()


def _value(xml: XmlFile, element: Element, place: str, default: float, *names: str) -> float:
    """Return the first positive number under one of these plain names."""
    text = next(_texts(element, *names), None)
    return default if text is None else xml.positive(text, 1, f"{place} <{names[0]}>")[0]


def _drive(xml: XmlFile, plugin: Element, urdf: Urdf) -> DriveSettings | None:
    name = plugin.get("name") or plugin.get("filename") or "?"
    place = f"plugin '{name}'"
    left, right = tuple(_texts(plugin, *_LEFT)), tuple(_texts(plugin, *_RIGHT))
    if not left or not right:
        xml.note(f"{place}: not simulated")
        return None
    for joint in left + right:
        if joint not in urdf.joints:
            problem = f"joint '{joint}' does not exist; {nearest(joint, urdf.joints)}"
            raise xml.fail(place, problem)
    diameter = _value(xml, plugin, place, 0.0, "wheeldiameter")
    radius = diameter / 2 or _value(xml, plugin, place, 0.0, "wheelradius")
    radius = radius or _wheel_radius(xml, urdf, left + right)
    separation = _value(xml, plugin, place, 0.0, "wheelseparation")
    separation = separation or _wheel_separation(urdf, left, right)
    return DriveSettings(
        left,
        right,
        separation,
        radius,
        _value(xml, plugin, place, _TORQUE, "torque", "wheeltorque", "maxwheeltorque"),
        _value(xml, plugin, place, separation, "effectivetrackwidth"),
        _value(xml, plugin, place, radius, "effectivewheelradius"),
    )


def guess_drive(
    xml: XmlFile, urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]
) -> DriveSettings:
    """Return the drive of a robot without a drive plugin, by its wheels' places and shapes.

    Raises:
        RobotError: No wheel is round.
    """
    xml.note(f"no drive plugin: driven are the joints {', '.join(left + right)}")
    separation = _wheel_separation(urdf, left, right)
    radius = _wheel_radius(xml, urdf, left + right)
    return DriveSettings(left, right, separation, radius, _TORQUE, separation, radius)


def _wheel_separation(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return the distance between the mean left and the mean right wheel [m]."""
    y = {n: urdf.T_root(urdf.joints[n].child).position[1] for n in left + right}
    return abs(sum(y[n] for n in left) / len(left) - sum(y[n] for n in right) / len(right))


def _wheel_radius(xml: XmlFile, urdf: Urdf, joints: tuple[str, ...]) -> float:
    """Return the radius of the first wheel that has a round collision shape [m]."""
    for name in joints:
        for part in urdf.links[urdf.joints[name].child].collisions:
            if part.shape.kind in (Kind.CYLINDER, Kind.SPHERE):
                return part.shape.size[0]
    raise xml.fail("drive", "the wheels' radius is unknown; <wheelDiameter> gives it")


def _sort_sensor(
    xml: XmlFile, sensor: Element, link: str, sensors: dict[str, tuple[Element, str]]
) -> None:
    """Keep the first sensor of each kind; note the others."""
    kind = sensor.get("type", "?")
    place = f"sensor '{sensor.get('name', kind)}'"
    if kind not in _SENSORS:
        xml.note(f"{place}: type '{kind}' is not simulated; simulated are {', '.join(_SENSORS)}")
        return
    key = "lidar" if kind in _LIDARS else kind
    if key in sensors:
        xml.note(f"{place}: a second {key} is not simulated")
        return
    sensors[key] = (sensor, link)


def _frame(sensor: Element, link: str) -> str:
    frame = next(_texts(sensor, "framename", "gzframeid", "ignitionframeid"), link)
    return frame.lstrip("/")


def _lidar(xml: XmlFile, sensor: Element, link: str) -> LidarSettings:
    place = f"sensor '{sensor.get('name', 'lidar')}'"
    ray = sensor.find("ray")
    ray = sensor.find("lidar") if ray is None else ray
    horizontal = None if ray is None else ray.find("scan/horizontal")
    samples = int(xml.number(horizontal, "samples", 360, place))
    angle_min = xml.number(horizontal, "min_angle", -math.pi, place)
    angle_max = xml.number(horizontal, "max_angle", math.pi, place)
    range_min = xml.number(ray, "range/min", 0.1, place)
    range_max = xml.number(ray, "range/max", 10.0, place)
    rate = xml.number(sensor, "update_rate", 10.0, place)
    if not 1 <= samples <= 100_000:
        raise xml.fail(place, f"<samples> is {samples}; valid: 1 to 100000")
    if not angle_min < angle_max:
        raise xml.fail(place, f"<min_angle> {angle_min} must be below <max_angle> {angle_max}")
    if not 0.0 <= range_min < range_max:
        raise xml.fail(place, f"<range> {range_min} to {range_max} must be 0 <= min < max")
    if not rate > 0.0:
        raise xml.fail(place, f"<update_rate> is {rate}; it must be above zero")
    if ray is not None and xml.number(ray, "scan/vertical/samples", 1, place) > 1:
        xml.note(f"{place}: only the level plane is simulated of its vertical samples")
    noise = xml.number(ray, "noise/stddev", xml.number(sensor, "noise/stddev", 0.0, place), place)
    if noise < 0.0:
        raise xml.fail(place, f"<stddev> is {noise}; it must not be negative")
    frame = _frame(sensor, link)
    return LidarSettings(
        link, frame, samples, angle_min, angle_max, range_min, range_max, rate, noise
    )


def _camera(xml: XmlFile, sensor: Element, link: str) -> CameraSettings:
    place = f"sensor '{sensor.get('name', 'camera')}'"
    camera = sensor.find("camera")
    settings = CameraSettings(
        link,
        _frame(sensor, link),
        int(xml.number(camera, "image/width", 640, place)),
        int(xml.number(camera, "image/height", 480, place)),
        xml.number(camera, "horizontal_fov", 1.047, place),
        xml.number(camera, "clip/near", 0.05, place),
        xml.number(camera, "clip/far", 100.0, place),
        xml.number(sensor, "update_rate", 30.0, place),
    )
    if not (0 < settings.width <= 4096 and 0 < settings.height <= 4096):
        problem = f"image is {settings.width} x {settings.height}; valid: 1 to 4096 pixels"
        raise xml.fail(place, problem)
    if not 0.0 < settings.horizontal_fov < math.pi:
        problem = f"<horizontal_fov> is {settings.horizontal_fov}; valid: above 0, below pi"
        raise xml.fail(place, problem)
    if not settings.rate > 0.0:
        raise xml.fail(place, f"<update_rate> is {settings.rate}; it must be above zero")
    return settings


def _imu(xml: XmlFile, sensor: Element, link: str) -> ImuSettings:
    place = f"sensor '{sensor.get('name', 'imu')}'"
    rate = xml.number(sensor, "update_rate", 50.0, place)
    if not rate > 0.0:
        raise xml.fail(place, f"<update_rate> is {rate}; it must be above zero")
    return ImuSettings(link, _frame(sensor, link), rate)
