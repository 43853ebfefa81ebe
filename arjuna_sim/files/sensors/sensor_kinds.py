"""Which types of sensors are simulated, and which of a robot's sensors are its first ones."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sensors import sensor_tags
from arjuna_sim.files.sensors.camera_tags import camera
from arjuna_sim.files.sensors.lidar_tags import lidars, sonar, surroundings
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import (
    CameraSettings,
    ImuSettings,
    LidarSettings,
    SensorSettings,
)

Reader = Callable[[XmlFile, Element, str], list[SensorSettings]]
_One = Callable[[XmlFile, Element, str], SensorSettings]


def _one(read: _One) -> Reader:
    return lambda xml, sensor, link: [read(xml, sensor, link)]


def _colours(xml: XmlFile, sensor: Element, link: str) -> list[SensorSettings]:
    return [camera(xml, sensor, link, depth=False)]


def _distances(xml: XmlFile, sensor: Element, link: str) -> list[SensorSettings]:
    return [camera(xml, sensor, link, depth=True)]


KINDS: dict[str, Reader] = {
    **dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), lidars),
    **dict.fromkeys(("camera", "wideanglecamera", "multicamera"), _colours),
    **dict.fromkeys(("depth", "depth_camera", "rgbd_camera", "rgbd"), _distances),
    **dict.fromkeys(("gps", "navsat"), _one(sensor_tags.navsat)),
    "imu": _one(sensor_tags.imu),
    "sonar": _one(sonar),
    "magnetometer": _one(sensor_tags.magnetometer),
    "altimeter": _one(sensor_tags.altimeter),
    "contact": _one(sensor_tags.bumper),
}
"""By type, what reads a sensor."""


@dataclass(frozen=True)
class FirstSensors:
    """A robot's sensors: those that the rest of the robot listens to, and the others."""

    lidar: LidarSettings | None
    camera: CameraSettings | None
    imu: ImuSettings | None
    further: tuple[SensorSettings, ...]


def settle(xml: XmlFile, sensors: list[SensorSettings]) -> FirstSensors:
    """Choose a robot's first sensors, and give each a name and a topic of its own.

    Args:
        xml: Keeps the notes.
        sensors: All of them, in the file's order.
    """
    cameras = [s for s in sensors if isinstance(s, CameraSettings)]
    colour = next((s for s in cameras if not s.depth), None) or next(iter(cameras), None)
    imu = next((s for s in sensors if isinstance(s, ImuSettings)), None)
    lidar = surroundings(sensors)
    chosen = [s for s in (lidar, colour, imu) if s is not None]
    further = [s for s in sensors if not any(s is other for other in chosen)]
    apart = list(_apart(xml, [*chosen, *further]))
    by_kind = dict(zip((id(s) for s in chosen), apart, strict=False))
    return FirstSensors(
        lidar and by_kind[id(lidar)],  # type: ignore[arg-type]
        colour and by_kind[id(colour)],  # type: ignore[arg-type]
        imu and by_kind[id(imu)],  # type: ignore[arg-type]
        tuple(apart[len(chosen) :]),
    )


def _apart(xml: XmlFile, sensors: Iterable[SensorSettings]) -> Iterable[SensorSettings]:
    """Yield sensors whose names and topics no other has; say which topics are changed."""
    names: set[str] = set()
    topics: set[str] = set()
    for sensor in sensors:
        name, number = sensor.name, 1
        while name in names:
            number += 1
            name = f"{sensor.name}_{number}"
        topic = sensor.topic
        if topic.lstrip("/") in topics:
            topic = f"{name}/{sensor.topic.rpartition('/')[2]}"
            xml.note(f"sensor '{name}': publishes on {topic}, since {sensor.topic} is another's")
        names.add(name)
        topics.add(topic.lstrip("/"))
        yield dataclasses.replace(sensor, name=name, topic=topic)
