"""Reading a robot's lidars, sonars and infrared sensors."""

from __future__ import annotations

import dataclasses
import math
from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sensors.sensor_tags import deviation, first, mount, place_of
from arjuna_sim.files.urdf.gazebo_text import plain, text_of
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import (
    TOPICS,
    CloudSettings,
    LidarSettings,
    RangeSettings,
    SensorSettings,
)

_BEAMS_MAX = 100_000
_RANGE_MAX = 10_000.0
_CLOUD = ("pointcloud", "velodyne", "blocklaser", "ouster", "livox")
_SEES = (16, math.pi / 3)  # samples and angle from which a lidar shows the surroundings
_SONAR = (9, 0.1)  # rays along each side of a sonar's cone; its radius far away, where none is told


def lidars(xml: XmlFile, sensor: Element, link: str) -> list[SensorSettings]:
    """Read what a lidar publishes: a scan, a cloud of points, a range, or two of them.

    Raises:
        RobotError: A value is invalid.
    """
    place = place_of(sensor)
    told: dict[str, Any] = mount(xml, sensor, link, 10.0, TOPICS["lidar"])
    told |= _beams(xml, sensor, place)
    rows, low, high = _rows(xml, sensor, place)
    kind = _output(sensor)
    if told["samples"] * rows > _BEAMS_MAX:
        problem = f"has {told['samples']} x {rows} samples; valid: up to {_BEAMS_MAX}"
        raise xml.fail(place, problem)
    tall: dict[str, Any] = {"rows": rows, "tilt_min": low, "tilt_max": high}
    if "range" in kind:
        infrared = "infrared" in text_of(sensor, "radiation", "radiationtype").lower()
        return [RangeSettings(**told, **tall, infrared=infrared)]
    if any(word in kind for word in _CLOUD):
        return [CloudSettings(**told, **tall)]
    level = LidarSettings(**told)
    if rows == 1:
        return [level]
    level = dataclasses.replace(level, name=f"{level.name}_level")
    if sensor.find("plugin") is not None:
        xml.note(f"{place}: only the level plane is simulated of its vertical samples")
        return [level]
    points = dataclasses.replace(CloudSettings(**told, **tall), topic=f"{level.topic}/points")
    return [points, level]


def sonar(xml: XmlFile, sensor: Element, link: str) -> RangeSettings:
    """Read a sonar: a cone of rays.

    Raises:
        RobotError: A value is invalid.
    """
    place, tag = place_of(sensor), sensor.find("sonar")
    low, high = xml.number(tag, "min", 0.0, place), xml.number(tag, "max", 1.0, place)
    radius = xml.number(tag, "radius", 0.5, place)
    if not (0.0 <= low < high and radius > 0.0):
        raise xml.fail(place, f"<sonar> {low} to {high}, radius {radius} is none")
    half = math.atan2(radius, high)
    return RangeSettings(
        **mount(xml, sensor, link, 10.0, "sonar"),
        samples=_SONAR[0],
        angle_min=-half,
        angle_max=half,
        range_min=low,
        range_max=min(high, _RANGE_MAX),
        noise=deviation(xml, sensor, place, "noise") or 0.0,
        rows=_SONAR[0],
        tilt_min=-half,
        tilt_max=half,
    )


def surroundings(sensors: list[SensorSettings]) -> LidarSettings | None:
    """Return the planar lidar that is the robot's: the first that shows the surroundings.

    Where none does, it is the one of most samples; where all have several rows, the level plane of
    the first.
    """
    planar = [s for s in sensors if type(s) is LidarSettings]
    wide = [s for s in planar if s.samples >= _SEES[0] and s.angle_max - s.angle_min >= _SEES[1]]
    if wide:
        return wide[0]
    clouds = [s for s in sensors if type(s) is CloudSettings]
    if clouds and not any(s.samples > 1 for s in planar):
        names = [field.name for field in dataclasses.fields(LidarSettings)]
        told = {name: getattr(clouds[0], name) for name in names}
        own = {"name": f"{clouds[0].name}_level", "topic": TOPICS["lidar"]}
        return LidarSettings(**{**told, **own})
    return max(planar, key=lambda s: s.samples, default=None)


def _beams(xml: XmlFile, sensor: Element, place: str) -> dict[str, Any]:
    """Return angles, ranges and noise."""
    ray = first(sensor, "ray", "lidar")
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
    return {
        "samples": samples,
        "angle_min": angle_min,
        "angle_max": angle_max,
        "range_min": range_min,
        "range_max": range_max,
        "noise": deviation(xml, sensor, place, "ray/noise", "lidar/noise", "noise") or 0.0,
    }


def _rows(xml: XmlFile, sensor: Element, place: str) -> tuple[int, float, float]:
    """Return how many rows there are, and the tilt of the lowest and the highest [rad]."""
    ray = first(sensor, "ray", "lidar")
    vertical = None if ray is None else ray.find("scan/vertical")
    rows = max(1, xml.count(vertical, "samples", 1, place))
    low = xml.number(vertical, "min_angle", 0.0, place)
    high = xml.number(vertical, "max_angle", 0.0, place)
    if not (low <= high and max(abs(low), abs(high)) <= math.pi / 2):
        raise xml.fail(place, f"<vertical> {low} to {high} must rise within pi / 2")
    return rows, low, high


def _output(sensor: Element) -> str:
    """Return words that say what a lidar's plugins publish, without case and underscores."""
    words = [text_of(sensor, "outputtype")]
    words += [p.get("filename", "") for p in sensor.findall("plugin")]
    return plain("".join(words).replace("sensor_msgs/", ""))
