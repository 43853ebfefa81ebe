"""A generator of robots with sensors of every form, mounted anyhow, and what each of them is."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings, RangeSettings
from arjuna_sim.model.settings import SensorSettings

LEVEL, UPSIDE_DOWN, AHEAD = (0.0, 0.0, 0.0), (math.pi, 0.0, 0.0), (0.0, 0.0, 0.4)
DOWN, STEEP, UPRIGHT = (0.0, math.pi / 2, 0.0), (0.0, 1.4, 2.9), (math.pi / 2, 0.0, 0.0)
FRAMES = ("{}", "<gz_frame_id>{}</gz_frame_id>", "<ignition_frame_id>{}</ignition_frame_id>")
_PLUGIN = '<plugin name="p" filename="{}">{}</plugin>'


@dataclass(frozen=True)
class Form:
    """A form in which files write a sensor of rays.

    Attributes:
        name: What others call it.
        types: Of its tags, any of which may stand there.
        samples: Across, and the angle that they span [rad].
        rows: One above the other, and the angle that they span [rad].
        reach: [m].
        mounts: Roll, pitch and yaw, any of them [rad].
        plugins: What it holds, `FRAME` where a frame is named; any of them.
        outputs: The kinds of settings that it makes.
        leads: Whether SLAM may take its scan.
        infrared: Of a range.
    """

    name: str
    types: tuple[str, ...]
    samples: tuple[int, float]
    rows: tuple[int, float]
    reach: float
    mounts: tuple[tuple[float, float, float], ...]
    plugins: tuple[str, ...]
    outputs: tuple[type[SensorSettings], ...]
    leads: bool = False
    infrared: bool = False


_RAYS, _GZ = ("ray", "gpu_ray"), ("gpu_lidar", "lidar")
_OWN = _PLUGIN.format("libmaker_cliff_sensor.so", "<frame_id>FRAME</frame_id>")
_SCAN = _PLUGIN.format("libgazebo_ros_ray_sensor.so", "<output_type>sensor_msgs/LaserScan{}")
_SCAN = _SCAN.format("</output_type><frame_name>FRAME</frame_name>")
_OWN_RAYS = _SCAN.replace("</plugin>", "RAYS</plugin>")
_RANGE = _PLUGIN.format("libgazebo_ros_range.so", "<radiation>{}</radiation>")
_ROUND, _LOOKS_DOWN = (LEVEL, UPSIDE_DOWN, AHEAD), (DOWN, STEEP)
_ALL, _ONE = (*_ROUND, *_LOOKS_DOWN), (1, 0.0)
FORMS = (
    Form("lidar", _GZ, (360, 6.28), _ONE, 12.0, _ROUND, ("",), (LidarSettings,), True),
    Form("laser", _RAYS, (720, 3.0), _ONE, 30.0, _ROUND, (_SCAN, ""), (LidarSettings,), True),
    Form("profile", _RAYS, (90, 2.0), _ONE, 5.0, (*_LOOKS_DOWN, UPRIGHT), (_SCAN, ""),
         (LidarSettings,)),
    Form("cliff", _RAYS, (1, 0.09), _ONE, 0.15, _LOOKS_DOWN, (_OWN, ""), (RangeSettings,),
         infrared=True),
    Form("many rays", _RAYS, (50, 0.0872), _ONE, 0.15, _LOOKS_DOWN, ("",), (RangeSettings,),
         infrared=True),
    Form("intensity", (*_RAYS, *_GZ), (5, 0.17), (5, 0.17), 0.2, _ALL, (_OWN, ""),
         (RangeSettings,), infrared=True),
    Form("time of flight", _GZ, (1, 0.02), _ONE, 0.9, _ALL, ("",), (RangeSettings,),
         infrared=True),
    Form("ultrasound", _RAYS, (9, 0.5), (9, 0.5), 4.0, _ALL, (_RANGE.format("ultrasound"),),
         (RangeSettings,)),
    Form("red", _RAYS, (9, 0.5), (3, 0.2), 1.0, _ALL, (_RANGE.format("infrared"),),
         (RangeSettings,), infrared=True),
    Form("beam", _RAYS, (1, 0.0), _ONE, 8.0, _ALL, (_SCAN,), (LidarSettings,)),
    Form("rays in a plugin", _RAYS, (360, 6.28), _ONE, 50.0, _ROUND, (_OWN_RAYS,),
         (LidarSettings,), True),
    Form("rows", _GZ, (90, 6.28), (8, 0.5), 50.0, _ROUND, ("",), (CloudSettings, LidarSettings),
         True),
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A sensor of a generated robot."""

    name: str
    form: Form
    frame: str
    T_base: Pose3


@dataclass(frozen=True)
class SensorRobot:
    """A generated robot: its file's text and suffix, and its sensors in the file's order."""

    text: str
    suffix: str
    cases: tuple[Case, ...]

    def write(self, folder: Path) -> Path:
        """Write it; return its file."""
        path = folder / f"r{self.suffix}"
        path.write_text(self.text, encoding="utf-8")
        return path


def sensor_robots(count: int, seed: int = 0) -> Iterator[SensorRobot]:
    """Yield robots with one to nine sensors of rays, as URDF and as SDF by turns."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        forms = [FORMS[i] for i in rng.integers(len(FORMS), size=1 + number % 9)]
        cases, tags = [], []
        for i, form in enumerate(forms):
            plugin, kind = (str(rng.choice(each)) for each in (form.plugins, form.types))
            link, own = f"s{i}_link", f"s{i}_frame"
            named = rng.random() < 0.5
            frame = own if named else link
            given = "" if "FRAME" in plugin or not named else str(rng.choice(FRAMES[1:]))
            rpy = form.mounts[rng.integers(len(form.mounts))]
            x, y, z = rng.uniform((-0.1, -0.1, 0.1), (0.1, 0.1, 0.3)).tolist()
            T = Pose3.from_rpy((x, y, z), rpy)
            cases.append(Case(f"s{i}", form, frame, T))
            tags.append(_tag(form, f"s{i}", kind, (plugin + given).replace("FRAME", "{}"), frame))
        yield _robot(number, cases, tags)


def _tag(form: Form, name: str, kind: str, inside: str, frame: str) -> str:
    (across, wide), (rows, high) = form.samples, form.rows
    ray = "lidar" if kind in _GZ else "ray"
    fan = "<{0}><samples>{1}</samples><min_angle>{2}</min_angle><max_angle>{3}</max_angle></{0}>"
    scan = fan.format("horizontal", across, -wide / 2, wide / 2)
    scan += fan.format("vertical", rows, -high / 2, high / 2)
    limits = f"<range><min>0.01</min><max>{form.reach}</max></range>"
    rays = f"<{ray}><scan>{scan}</scan>{limits}</{ray}>"
    inside = inside.replace("{}", frame)
    rays = inside.replace("RAYS", rays) if "RAYS" in inside else inside + rays
    return (
        f'<sensor name="{name}" type="{kind}"><update_rate>10</update_rate>'
        f"<topic>{name}/out</topic>{rays}</sensor>"
    )


def _robot(number: int, cases: list[Case], tags: list[str]) -> SensorRobot:
    if number % 2:
        links = "".join(
            f'<link name="{c.name}_link"><pose>{_numbers(c.T_base.position)}'
            f" {_numbers(c.T_base.rpy())}</pose>{tag}</link><joint type='fixed' name='{c.name}_j'>"
            f"<parent>base</parent><child>{c.name}_link</child></joint>"
            for c, tag in zip(cases, tags, strict=True)
        )
        base = "<link name='base'><inertial><mass>3</mass></inertial></link>"
        text = f"<sdf version='1.9'><model name='r'>{base}{links}</model></sdf>"
        return SensorRobot(text, ".sdf", tuple(cases))
    links = "".join(
        f'<link name="{c.name}_link"/><joint name="{c.name}_j" type="fixed"><parent link="base"/>'
        f'<child link="{c.name}_link"/><origin xyz="{_numbers(c.T_base.position)}"'
        f' rpy="{_numbers(c.T_base.rpy())}"/></joint><gazebo reference="{c.name}_link">{tag}'
        "</gazebo>"
        for c, tag in zip(cases, tags, strict=True)
    )
    base = "<link name='base'><inertial><mass value='3'/></inertial></link>"
    return SensorRobot(f"<robot name='r'>{base}{links}</robot>", ".urdf", tuple(cases))


def _numbers(values: tuple[float, float, float]) -> str:
    return " ".join(repr(float(value)) for value in values)
