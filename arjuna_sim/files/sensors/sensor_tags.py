"""Reading what a robot's `<sensor>` tags have in common, and those of its motion and its place."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.pose3 import ORIGIN
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.urdf.gazebo_text import text_of, topic, value
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import (
    TOPICS,
    AltimeterSettings,
    BumperSettings,
    ImuSettings,
    MagnetometerSettings,
    NavSatSettings,
)

_RATE_MAX = 1000.0


def place_of(sensor: Element) -> str:
    """Return how messages call a sensor."""
    return f"sensor '{sensor.get('name') or sensor.get('type') or '?'}'"


def mount(xml: XmlFile, sensor: Element, link: str, rate: float, name: str) -> dict[str, Any]:
    """Return what all sensors have, as keywords of their settings.

    Args:
        xml: The file.
        sensor: The `<sensor>`.
        link: The link that carries it.
        rate: Where the file names none [Hz].
        name: The topic where the file names none.

    Raises:
        RobotError: Its pose or rate is invalid.
    """
    place, pose = place_of(sensor), ORIGIN
    for element in (sensor, sensor.find("camera")):
        if element is not None and element.find("pose") is not None:
            pose = pose @ raw_pose(xml, element, place)
    return {
        "link": link,
        "frame": frame_of(sensor, link),
        "rate": _rate(xml, sensor, rate, place),
        "topic": topic(sensor, name, "~/out", "topicname", "topic"),
        "name": (sensor.get("name") or sensor.get("type") or "sensor").strip(),
        "pose": pose,
    }


def frame_of(sensor: Element, link: str) -> str:
    """Return the frame that a sensor's messages name, its link where the file names none."""
    names = ("framename", "gzframeid", "ignitionframeid")
    return text_of(sensor, *names, default=link).lstrip("/")


def first(element: Element, *tags: str) -> Element | None:
    """Return the first child that has one of these tags."""
    return next((found for tag in tags if (found := element.find(tag)) is not None), None)


def _rate(xml: XmlFile, sensor: Element, default: float, place: str) -> float:
    rate = xml.number(sensor, "update_rate", default, place)
    if not 0.0 <= rate <= _RATE_MAX:
        raise xml.fail(place, f"<update_rate> is {rate}; valid: above 0, up to {_RATE_MAX:g} Hz")
    if rate == 0.0:
        xml.note(f"{place}: <update_rate> 0 is taken as {default:g} Hz")
    return rate or default


def deviation(xml: XmlFile, sensor: Element, place: str, *paths: str) -> float | None:
    """Return the standard deviation of the first noise that is there; None where there is none.

    Raises:
        RobotError: It is negative.
    """
    found = (sensor.findtext(f"{path}/stddev") for path in paths)
    text = next((text for text in found if text), None) or text_of(sensor, "gaussiannoise")
    if not text:
        return None
    noise = xml.numbers(text, 1, f"{place} <stddev>")[0]
    if noise < 0.0:
        raise xml.fail(place, f"<stddev> is {noise}; it must not be negative")
    return noise


def imu(xml: XmlFile, sensor: Element, link: str) -> ImuSettings:
    """Read an IMU.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    return ImuSettings(
        **mount(xml, sensor, link, 50.0, TOPICS["imu"]),
        gyro_noise=deviation(
            xml, sensor, place, "imu/angular_velocity/x/noise", "imu/noise/rate", "imu/noise/rates"
        ),
        accel_noise=deviation(
            xml, sensor, place, "imu/linear_acceleration/x/noise", "imu/noise/accel"
        ),
    )


def imu_plugin(xml: XmlFile, plugin: Element) -> ImuSettings:
    """Read an IMU that a ROS 1 plugin attaches to a link without a sensor.

    Raises:
        RobotError: The rate is invalid.
    """
    name = plugin.get("name", "?")
    place, link = f"plugin '{name}'", text_of(plugin, "bodyname", "bodyid")
    rate = value(xml, plugin, place, 50.0, "updaterate")
    if rate > _RATE_MAX:
        raise xml.fail(place, f"<updateRate> is {rate}; valid: up to {_RATE_MAX:g} Hz")
    frame = text_of(plugin, "frameid", "framename", default=link).lstrip("/")
    told = topic(plugin, TOPICS["imu"], "~/out", "topicname")
    return ImuSettings(link=link, frame=frame, rate=rate, topic=told, name=name)


def navsat(xml: XmlFile, sensor: Element, link: str) -> NavSatSettings:
    """Read a GPS.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    level, upright = (
        deviation(xml, sensor, place, *(f"{tag}/position_sensing/{key}/noise" for tag in _GPS))
        for key in ("horizontal", "vertical")
    )
    return NavSatSettings(
        **mount(xml, sensor, link, 5.0, "gps/fix"),
        noise=level or 0.0,
        height_noise=upright or 0.0,
    )


_GPS = ("navsat", "gps")


def magnetometer(xml: XmlFile, sensor: Element, link: str) -> MagnetometerSettings:
    """Read a magnetometer.

    Raises:
        RobotError: A value is invalid.
    """
    noise = deviation(xml, sensor, place_of(sensor), "magnetometer/x/noise")
    return MagnetometerSettings(**mount(xml, sensor, link, 20.0, "imu/mag"), noise=noise or 0.0)


def altimeter(xml: XmlFile, sensor: Element, link: str) -> AltimeterSettings:
    """Read an altimeter.

    Raises:
        RobotError: A value is invalid.
    """
    noise = deviation(xml, sensor, place_of(sensor), "altimeter/vertical_position/noise")
    return AltimeterSettings(**mount(xml, sensor, link, 20.0, "altimeter"), noise=noise or 0.0)


def bumper(xml: XmlFile, sensor: Element, link: str) -> BumperSettings:
    """Read a bumper.

    Raises:
        RobotError: A value is invalid.
    """
    told = mount(xml, sensor, link, 50.0, f"{sensor.get('name', 'bumper')}/contacts")
    own = text_of(sensor, "bumpertopicname") or sensor.findtext("contact/topic") or ""
    return BumperSettings(**{**told, "topic": own.strip() or told["topic"]})
