"""Lidars, planar and of several rows, sonars and infrared sensors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.config import fixed, share_param
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import plain, value
from arjuna_sim.model.settings import SensorSettings, chooses, reads
from arjuna_sim.model.urdf import Urdf

_BEAMS_MAX = 100_000  # of a lidar, so that a hostile file cannot stop the simulation
_RANGE_MAX = 10_000.0  # [m]
_CLOUD = ("pointcloud", "velodyne", "blocklaser", "ouster", "livox")
_SEES = (16, math.pi / 3)  # samples and angle from which a lidar shows the surroundings
_SONAR_RAYS = 9  # along each side of a sonar's cone
_CONE = math.radians(31.0)  # the widest of what measures one range: sonars have 15 to 30 degrees
_LEVEL, _TILTED = math.radians(15.0), math.radians(45.0)
"""Tilts of a lidar that shows the surroundings, and of one that does where there is no better."""


@dataclass(frozen=True)
class LidarConfig:
    """Errors of the lidar."""

    noise: float = fixed(
        -1.0,
        "Standard deviation of a range; below 0 takes that of the robot's file.",
        unit="m",
        minimum=-1.0,
        maximum=1.0,
    )
    dropout: float = share_param(
        0.0, "Part of the beams that return nothing, read as +inf.", read_only=True
    )
    sweep: bool = fixed(
        False,
        "Whether each beam is cast at its own instant while the robot moves, as a turning lidar's;"
        " else all at once.",
    )


@dataclass(frozen=True, kw_only=True)
class LidarSettings(SensorSettings):
    """A planar lidar: angles [rad], ranges [m], standard deviation of noise [m].

    Attributes:
        rendered: Whether it sees what is drawn, rather than what is solid.
    """

    TITLE: ClassVar[str] = "lidar"
    IS_PRIMARY: ClassVar[bool] = True
    TOPIC: ClassVar[str] = "scan"
    samples: int
    angle_min: float
    angle_max: float
    range_min: float
    range_max: float
    noise: float
    rendered: bool = False
    topic: str = TOPIC

    def details(self) -> str:
        """Return samples, angles, ranges and noise."""
        return self._beams(f"{self.samples}")

    def _beams(self, samples: str) -> str:
        low, high = math.degrees(self.angle_min), math.degrees(self.angle_max)
        return (
            f"{samples} samples, {low:.1f} to {high:.1f} deg,"
            f" {self.range_min:g} to {self.range_max:g} m, noise {self.noise:g} m"
            f"{', sees what is drawn' if self.rendered else ''}"
        )


@dataclass(frozen=True, kw_only=True)
class CloudSettings(LidarSettings):
    """A lidar of several rows, and the tilt upward of its lowest and its highest [rad]."""

    TITLE: ClassVar[str] = "lidar of several rows"
    IS_PRIMARY: ClassVar[bool] = False
    rows: int
    tilt_min: float
    tilt_max: float

    def details(self) -> str:
        """Return samples of all rows, angles, ranges and noise."""
        return self._beams(f"{self.samples} x {self.rows}")


@dataclass(frozen=True, kw_only=True)
class RangeSettings(CloudSettings):
    """A sonar or infrared sensor, which measures the nearest range in its cone."""

    TITLE: ClassVar[str] = "range sensor"
    infrared: bool = False


@reads("ray", "gpu_ray", "lidar", "gpu_lidar")
def read_lidar(tag: SensorTag) -> list[SensorSettings]:
    """Read the outputs of a lidar: a scan, a cloud of points, a range, or several of them.

    As in Gazebo a `gpu_` one sees visuals, any other collisions.

    Raises:
        RobotError: A value is invalid.
    """
    named = [p for p in tag.element.findall("plugin") if p.find("output_type") is not None]
    if len(named) > 1:  # each publishes what it names
        return [sensor for plugin in named for sensor in read_lidar(tag.with_plugin(plugin))]
    beams, rows, output = _beams_of(tag), _rows_of(tag), _output(tag)
    if beams["samples"] * rows["rows"] > _BEAMS_MAX:
        problem = f"has {beams['samples']} x {rows['rows']} samples"
        raise tag.fail(f"{problem}; valid: up to {_BEAMS_MAX}")
    is_cloud = any(word in output for word in _CLOUD)
    # Gazebo Sim's, by their types, publish scans however narrow: its bridge knows no ranges.
    is_scan = "laser" in output or tag.element.get("type", "") in ("lidar", "gpu_lidar")
    if (
        "range" in output
        or "sonar" in output
        or (not (is_cloud or is_scan) and _is_cone(beams, rows))
    ):
        mount = tag.mount(10.0, tag.own_topic("range"))
        return [RangeSettings(**mount, **beams, **rows, infrared=_is_infrared(tag, output))]
    beams |= tag.mount(10.0, LidarSettings.TOPIC)
    if is_cloud:
        if tag.text("outputtype").endswith("/PointCloud"):
            tag.note("publishes sensor_msgs/PointCloud2 in place of PointCloud")
        return [CloudSettings(**beams, **rows)]
    level = LidarSettings(**beams)
    if rows["rows"] == 1:
        return [level]
    if tag.element.find("plugin") is not None:
        tag.note("only the level plane is simulated of its vertical samples")
        return [level]
    points = dataclasses.replace(CloudSettings(**beams, **rows), topic=f"{level.topic}/points")
    return [points, dataclasses.replace(level, name=f"{level.name}_level")]


@reads("sonar")
def read_sonar(tag: SensorTag) -> list[RangeSettings]:
    """Read a sonar: a cone of rays.

    Raises:
        RobotError: A value is invalid.
    """
    if (cone := tag.element.find("sonar")) is None:
        tag.note("lacks <sonar>: it reaches 1 m, as Gazebo's, in a cone of 0.5 m radius")
    low, high, radius = (
        tag.xml.number(cone, key, default, tag.label)
        for key, default in (("min", 0.0), ("max", 1.0), ("radius", 0.5))
    )
    if not (0.0 <= low < high and radius > 0.0):
        raise tag.fail(f"<sonar> {low} to {high}, radius {radius} is none")
    half = math.atan2(radius, high)
    return [
        RangeSettings(
            **tag.mount(10.0, "sonar"),
            samples=_SONAR_RAYS,
            angle_min=-half,
            angle_max=half,
            range_min=low,
            range_max=min(high, _RANGE_MAX),
            noise=tag.deviation("noise") or 0.0,
            rows=_SONAR_RAYS,
            tilt_min=-half,
            tilt_max=half,
        )
    ]


@chooses(0)
def surroundings(sensors: Sequence[SensorSettings], urdf: Urdf) -> LidarSettings | None:
    """Return the first planar lidar that shows the surroundings; None where all look elsewhere.

    Where none does, it is the one of most samples; where all have several rows, the level plane of
    the first. One that looks down or along a slit shows none, however many beams it has.
    """
    found = (_chosen([s for s in sensors if _tilt(urdf, s) < most]) for most in (_LEVEL, _TILTED))
    return next((lidar for lidar in found if lidar is not None), None)


def level_lidars(sensors: Sequence[SensorSettings], urdf: Urdf) -> list[LidarSettings]:
    """Return a robot's planar lidars that look level, and before them the one that serves it."""
    planar = [s for s in sensors if type(s) is LidarSettings]
    return [s for s in planar if s.serves] + [
        s for s in planar if not s.serves and _tilt(urdf, s) < _LEVEL
    ]


def _tilt(urdf: Urdf, sensor: SensorSettings) -> float:
    """Return the angle between a sensor's own plane and the robot's [rad]."""
    upward = (urdf.T_root(sensor.link) @ sensor.pose).rotation()[2, 2]
    return math.acos(min(1.0, abs(float(upward))))


def _chosen(sensors: Sequence[SensorSettings]) -> LidarSettings | None:
    planar = [s for s in sensors if type(s) is LidarSettings and s.samples > 1]
    wide = [s for s in planar if s.samples >= _SEES[0] and s.angle_max - s.angle_min >= _SEES[1]]
    if wide:
        return wide[0]
    clouds = [s for s in sensors if type(s) is CloudSettings]
    if clouds and not planar:
        names = [field.name for field in dataclasses.fields(LidarSettings)]
        level = {name: getattr(clouds[0], name) for name in names}
        own = {"name": f"{clouds[0].name}_level", "topic": LidarSettings.TOPIC}
        return LidarSettings(**{**level, **own})
    return max(planar, key=lambda s: s.samples, default=None)


def _beams_of(tag: SensorTag) -> dict[str, Any]:
    ray = tag.first("ray", "lidar")
    across = None if ray is None else ray.find("scan/horizontal")
    xml, label = tag.xml, tag.label
    samples = _samples(tag, across, 360)
    angle_min = xml.number(across, "min_angle", -math.pi, label)
    angle_max = xml.number(across, "max_angle", math.pi, label)
    range_min = value(xml, tag.element, label, xml.number(ray, "range/min", 0.1, label), "minrange")
    range_max = min(xml.number(ray, "range/max", 10.0, label), _RANGE_MAX)
    range_max = min(value(xml, tag.element, label, range_max, "maxrange"), range_max)  # Velodyne's
    if not 1 <= samples <= _BEAMS_MAX:
        problem = f"<samples> times <resolution> is {samples}"
        raise tag.fail(f"{problem}; valid: 1 to {_BEAMS_MAX}")
    if not angle_min < angle_max and samples > 1:
        raise tag.fail(f"<min_angle> {angle_min} must be below <max_angle> {angle_max}")
    if not 0.0 <= range_min < range_max:
        raise tag.fail(f"<range> {range_min} to {range_max} must be 0 <= min < max")
    return {
        "samples": samples,
        "angle_min": angle_min,
        "angle_max": angle_max,
        "range_min": range_min,
        "range_max": range_max,
        "noise": tag.deviation("ray/noise", "lidar/noise", "noise") or 0.0,
        "rendered": tag.element.get("type", "").startswith("gpu_"),
    }


def _samples(tag: SensorTag, part: Element | None, default: int) -> int:
    """Return how many ranges a scan's part has: Gazebo multiplies samples by resolution."""
    samples = tag.xml.count(part, "samples", default, tag.label)
    return int(samples * tag.xml.number(part, "resolution", 1.0, tag.label))


def _rows_of(tag: SensorTag) -> dict[str, Any]:
    """Return the number of rows, and the tilts of the lowest and the highest [rad]."""
    ray = tag.first("ray", "lidar")
    upright = None if ray is None else ray.find("scan/vertical")
    rows = max(1, _samples(tag, upright, 1))
    low = tag.xml.number(upright, "min_angle", 0.0, tag.label)
    high = tag.xml.number(upright, "max_angle", 0.0, tag.label)
    if not (low <= high and max(abs(low), abs(high)) <= math.pi / 2):
        raise tag.fail(f"<vertical> {low} to {high} must rise within pi / 2")
    return {"rows": rows, "tilt_min": low, "tilt_max": high}


def _is_cone(beams: dict[str, Any], rows: dict[str, Any]) -> bool:
    """Return whether beams are as close together as those of one that measures one range."""
    across = 0.0 if beams["samples"] == 1 else beams["angle_max"] - beams["angle_min"]
    return bool(max(across, rows["tilt_max"] - rows["tilt_min"]) <= _CONE)


def _is_infrared(tag: SensorTag, output: str) -> bool:
    """Return what a range sensor radiates: light, unless its file or a ROS 1 plugin says sound."""
    is_sound = "gazeborosrange" in output or "sonar" in output
    default = "ultrasound" if is_sound else "infrared"
    return "infrared" in tag.text("radiation", "radiationtype", default=default).lower()


def _output(tag: SensorTag) -> str:
    """Return words on what a lidar's plugins publish, without case and underscores."""
    words = [tag.text("outputtype")]
    words += [p.get("filename", "") for p in tag.element.findall("plugin")]
    return plain("".join(words).replace("sensor_msgs/", ""))
