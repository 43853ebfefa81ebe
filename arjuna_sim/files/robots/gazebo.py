"""Making settings of a robot's tags: the drive and the sensors."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Sequence
from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_sim.files.robots.controllers import (
    broadcasts,
    drive_of_controllers,
    parameters_of_controllers,
)
from arjuna_sim.files.robots.drive_kinds import joined
from arjuna_sim.files.robots.joint_controllers import is_joint_plugin
from arjuna_sim.files.robots.plugins import (
    BATTERY,
    Sides,
    drive_kind,
    is_classic,
    is_control,
    is_done,
    name_of,
    read_drive,
    read_tracks,
    read_wheelless,
    sensor_type,
    types_of,
)
from arjuna_sim.files.sensor_tag import PluginTag, SensorTag, Tags
from arjuna_sim.files.tag_text import flag, is_true, plain, text_of, texts, value
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import (
    DriveKind,
    DriveSettings,
    PublishedPoses,
    SensorSettings,
    sensor_kinds,
)
from arjuna_sim.model.urdf import Urdf

_BARE = {BATTERY: BATTERY, "hectorgazeborosgps": "gps", "hectorgazeborosmagnetic": "magnetometer"}
"""Types of plugins that are sensors of a kind by themselves, without a `<sensor>`."""
_PUBLISHER = "odometrypublisher"
_TRUE = ("p3d", _PUBLISHER)  # kinds of plugins that publish true motion


class TagReader:
    """Reads a robot's plugins and sensors; what is not understood is noted.

    Attributes:
        drive: The drive, where a plugin names its wheels.
        kind: The kind of drive that a plugin names; None for none.
        wheelless: Topics, frames and limits of a drive plugin that names no wheels.
        is_classic: Whether Gazebo Classic's plugin turns the wheels, however fast their joints may.
        tracks: The links that are its left and its right tracks.
        reported: The joints whose states are published; none for all that move.
        report_rate: How often, 0 for each tick [Hz].
        poses: Which are published on `/model/NAME/pose`.
        truths: By their topics, the frames that OdometryPublishers' messages are in.

    Raises:
        RobotError: A plugin names a joint or link that does not exist, or a value is invalid.
    """

    def __init__(self, xml: XmlFile, urdf: Urdf, tags: Tags) -> None:
        self._xml = xml
        self._urdf = urdf
        self.drive: DriveSettings | None = None
        self.kind: DriveKind | None = None
        self.wheelless: DriveSettings | None = None
        self.is_classic = False
        self.tracks: Sides = (), ()
        self.reported: dict[str, None] = {}
        self.report_rate = 0.0
        self.poses = PublishedPoses()
        self.truths: dict[str, str] = {}
        self._sensors: list[SensorSettings] = []
        self._renamed: dict[str, dict[str, Any]] = {}
        self._broadcast: dict[str, dict[str, Any]] = {}
        published = {text_of(p, "bodyname") for p in tags.plugins if "imu" in _type(p)}
        for item in tags.items:
            if isinstance(item, PluginTag):
                self._plugin(item.element, item.link)
            elif not (item.link in published and _is_silent_imu(item.element)):
                self._sensor(item)

    def sensors(self) -> tuple[SensorSettings, ...]:
        """Return the sensors, the primary ones first."""
        found = [dataclasses.replace(s, **self._renamed.get(s.name, {})) for s in self._sensors]
        sent, own = self._broadcast, found
        found = [dataclasses.replace(s, **sent[s.name]) for s in own if s.name in sent]
        return tuple(with_primary_first(self._xml, self._urdf, [*found, *own]))

    def _plugin(self, plugin: Element, link: str | None) -> None:
        """Take a plugin."""
        xml, urdf = self._xml, self._urdf
        controlled = drive_of_controllers(xml, plugin) if is_control(plugin) else None
        self._broadcast |= broadcasts(xml, plugin)
        driving = plugin if controlled is None else controlled
        is_truth = any(each in _type(plugin).replace("-", "") for each in _TRUE)
        drive = None if is_truth else read_drive(xml, driving, urdf)
        kind = drive_kind(driving)
        name = name_of(plugin)
        self.is_classic |= controlled is None and kind is not None and is_classic(plugin)
        if drive is not None and self.drive is not None:
            both = joined(urdf, self.drive, drive) if kind is self.kind else None
            if both is None:
                xml.note(f"plugin '{name}': a second drive is not simulated", NoteKind.IGNORED)
            self.drive = both or self.drive
        elif drive is not None:
            self.drive, self.kind = drive, kind
        elif kind is not None:
            self.kind, self.wheelless = self.kind or kind, read_wheelless(xml, plugin, kind)
            self.tracks = read_tracks(xml, plugin, urdf)
        elif (body := text_of(plugin, "bodyname", "bodyid")) in urdf.links and "imu" in _type(
            plugin
        ):
            self._sensor(SensorTag(xml, plugin, body), "imu")
        elif (sensor := _BARE.get(types_of(plugin)[0], "")) != "":
            self._sensor(SensorTag(xml, plugin, body or urdf.root), sensor)
        else:
            self._other_plugin(plugin, name, link)

    def _other_plugin(self, plugin: Element, name: str, link: str | None) -> None:
        kind, sensor = _type(plugin), sensor_type(plugin)
        if is_joint_plugin(plugin) or "trackcontroller" in types_of(plugin):
            return  # as TrackedVehicle drives its tracks
        if sensor:
            self._xml.note(
                f"plugin '{name}': stands outside <sensor>, so that it makes none, as in Gazebo:"
                f" {remedy(self._urdf, sensor, link or text_of(plugin, 'framename'))}",
                NoteKind.BROKEN,
            )
        elif "jointstate" in kind:
            self._reports(plugin, f"plugin '{name}'")
        elif is_control(plugin):
            if not parameters_of_controllers(self._xml, plugin):
                problem = "name no controllers; a spawner's --param-file is not read"
                self._xml.note(f"plugin '{name}': its <parameters> {problem}")
        elif truth := next((each for each in _TRUE if each in kind.replace("-", "")), ""):
            body = text_of(plugin, "bodyname", default=link or self._urdf.root)
            self._sensor(SensorTag(self._xml, plugin, body), truth)
            if truth == _PUBLISHER:
                frame = text_of(plugin, "odomframe", default="odom")
                self.truths[self._sensors[-1].topic.lstrip("/")] = frame
        elif "realsensegazeboplugin" in types_of(plugin):
            self._renamed |= realsense_outputs(plugin)
        elif is_done(plugin):
            return
        elif "posepublisher" in kind:
            self.poses = self._poses(plugin)
        else:
            self._xml.note(f"plugin '{name}': not simulated", NoteKind.IGNORED)

    @staticmethod
    def _poses(plugin: Element) -> PublishedPoses:
        """Return what a PosePublisher says; of a robot's own pose an older tag speaks as well."""
        nested = flag(plugin, False, "publishnestedmodelpose")
        own = flag(plugin, nested, "publishmodelpose")
        return PublishedPoses(own, flag(plugin, True, "publishlinkpose"))

    def _reports(self, plugin: Element, label: str) -> None:
        """Take the joints whose states a plugin publishes; one that names none means all."""
        moving = [joint.name for joint in self._urdf.joints.values() if joint.has_position]
        named = [name for text in texts(plugin, "jointname") for name in re.split(r"[\s,]+", text)]
        for joint in named:
            if joint not in moving:
                text = f"{label}: joint '{joint}' does not move; {nearest(joint, moving)}"
                self._xml.note(text, NoteKind.IGNORED)
        known = [joint for joint in named if joint in moving]
        self.reported |= dict.fromkeys(known or moving)
        rate = value(self._xml, plugin, label, 0.0, "updaterate")
        self.report_rate = max(self.report_rate, rate)

    def _sensor(self, tag: SensorTag, kind: str = "") -> None:
        """Take a sensor, or a plugin of a kind, of which there may be any number of each."""
        kind, readers = kind or tag.element.get("type", "?"), sensor_kinds().readers
        if kind not in readers:
            problem = f"type '{kind}' is not simulated; simulated are {', '.join(readers)}"
            self._xml.note(f"{tag.label}: {problem}", NoteKind.IGNORED)
        elif tag.link not in self._urdf.links:
            problem = f"not simulated, since '{tag.link}' is no link"
            self._xml.note(f"{tag.label}: {problem}", NoteKind.IGNORED)
        else:
            self._sensors += readers[kind](tag)


def _is_silent_imu(sensor: Element) -> bool:
    """Return whether a `<sensor>` is an IMU that names neither a topic nor who publishes it."""
    return sensor.get("type") == "imu" and not [*sensor.iter("plugin"), *sensor.iter("topic")]


def _type(plugin: Element) -> str:
    return plain(plugin.get("filename", "") + plugin.get("name", ""))


def realsense_outputs(plugin: Element) -> dict[str, dict[str, Any]]:
    """Return topics and frames of the cameras that realsense_gazebo_plugin publishes, by name."""
    prefix, found = text_of(plugin, "prefix"), {}
    for camera, key, stream in (
        ("color", "color", "topic"),
        ("depth", "depth", "depth_topic"),
        ("ired1", "infrared1", "topic"),
        ("ired2", "infrared2", "topic"),
    ):
        folder = key.replace("infrared", "infra")
        picture = text_of(plugin, f"{key}topicname", default=f"{folder}/image_raw")
        info = text_of(plugin, f"{key}camerainfotopicname", default=f"{folder}/camera_info")
        made = {stream: f"{prefix}/{picture}", "info_topic": f"{prefix}/{info}"}
        frame = text_of(plugin, f"{key}opticalframename")
        made |= {"frame": frame} if frame else {}
        if stream == "depth_topic":
            points = text_of(plugin, "pointcloudtopicname", default="points")
            is_on = is_true(text_of(plugin, "pointcloud"))
            made |= {"cloud_topic": f"{prefix}/{points}" if is_on else ""}
        found[prefix + camera] = made
    return found


def remedy(urdf: Urdf, sensor: str, link: str) -> str:
    """Return the tags that a part of a sensor has to stand in."""
    named = link if link in urdf.links else "LINK"
    return f'put it into <gazebo reference="{named}"><sensor type="{sensor}" name="NAME">'


def with_primary_first(
    xml: XmlFile, urdf: Urdf, sensors: Sequence[SensorSettings]
) -> Iterator[SensorSettings]:
    """Yield sensors, the primary ones first, each with a name and a topic of its own.

    One whose file names its topic has it before one that has it for want of a name.
    """
    sensors = sorted(sensors, key=lambda sensor: not sensor.is_named)
    chosen = [s for choose in sensor_kinds().choices if (s := choose(sensors, urdf)) is not None]
    further = [s for s in sensors if not any(s is other for other in chosen)]
    names: set[str] = set()
    topics: set[str] = set()
    for sensor in (*chosen, *further):
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
        serves = not sensor.IS_PRIMARY or any(sensor is first for first in chosen)
        yield dataclasses.replace(sensor, name=name, topic=topic, serves=serves)
