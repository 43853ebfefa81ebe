"""Reading a URDF's Gazebo tags: the drive, the sensors, friction and colours."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_sim.files.material_colours import gazebo_colour
from arjuna_sim.files.sensors.sensor_kinds import KINDS, settle
from arjuna_sim.files.sensors.sensor_tags import imu_plugin, place_of
from arjuna_sim.files.urdf.controllers import drive_of_controllers
from arjuna_sim.files.urdf.gazebo_text import plain, text_of
from arjuna_sim.files.urdf.plugin_types import drive_kind, is_control, sensor_type
from arjuna_sim.files.urdf.plugins import read_drive, read_told
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import (
    DriveKind,
    DriveSettings,
    GazeboSettings,
    SensorSettings,
)
from arjuna_sim.model.urdf import Urdf

_CONTACT = ("kp", "kd")
_TRUE = ("true", "1")
_BELOW_SENSOR = {"ray": "ray", "lidar": "gpu_lidar", "camera": "camera", "imu": "imu"}
"""Tags that describe a sensor, and its type."""
_READ = ("fdir1", "sensor", "plugin", "mu1", "mu", "material", "visual", "mu2", *_CONTACT)


def read_gazebo(xml: XmlFile, urdf: Urdf) -> GazeboSettings:
    """Read drive, sensors, friction and colours; what is not understood becomes a note.

    Raises:
        RobotError: A plugin names a joint or link that does not exist, or a value is invalid.
    """
    reader = _Reader(xml, urdf)
    for gazebo in xml.root.findall("gazebo"):
        reader.read(gazebo)
    return reader.settings()


def _kind(plugin: Element) -> str:
    return plain(plugin.get("filename", "") + plugin.get("name", ""))


class _Reader:
    """Collects what the tags say."""

    def __init__(self, xml: XmlFile, urdf: Urdf) -> None:
        self._xml = xml
        self._urdf = urdf
        self._drive: DriveSettings | None = None
        self._kind: DriveKind | None = None
        self._told: DriveSettings | None = None
        self._grips: dict[str, tuple[float, float]] = {}
        self._uneven: list[str] = []
        self._friction: dict[str, float] = {}
        self._colours: dict[str, tuple[float, ...]] = {}
        self._stiffness: dict[str, dict[str, float]] = {}
        self._sensors: list[SensorSettings] = []
        self._left_out: dict[str, list[str]] = {}

    def read(self, gazebo: Element) -> None:
        """Take one `<gazebo>`."""
        link = gazebo.get("reference")
        if link is not None and link not in self._urdf.links and link not in self._urdf.joints:
            problem = f"reference '{link}' does not exist; {nearest(link, self._urdf.links)}"
            self._xml.note(f"gazebo {problem}; what it says is left out", NoteKind.MISSING)
            return
        for plugin in gazebo.findall("plugin"):
            self._plugin(plugin, link)
        for sensor in gazebo.findall("sensor"):
            self._sensor(sensor, link or self._urdf.root)
        if link is not None:
            self._surface(gazebo, link)
        for child in gazebo:
            if child.tag in _BELOW_SENSOR:
                cure = self._cure(_BELOW_SENSOR[child.tag], link or "")
                self._xml.note(
                    f"gazebo <{child.tag}>: stands outside <sensor>, so that there is none: {cure}",
                    NoteKind.BROKEN,
                )
                continue
            is_default = plain(child.tag) == "gravity" and (child.text or "").strip() in _TRUE
            if plain(child.tag) not in _READ and not is_default:
                self._left_out.setdefault(child.tag, []).append(link or "")

    def _surface(self, gazebo: Element, link: str) -> None:
        values = {}
        for child in gazebo:
            if plain(child.tag) in ("mu1", "mu", "mu2", *_CONTACT):
                place = f"gazebo '{link}' {child.tag}"
                text = (child.text or "").strip() or child.get("value", "")
                if not text:
                    self._xml.note(f"{place}: is empty, so it is left out", NoteKind.BROKEN)
                    continue
                values[plain(child.tag)] = self._xml.numbers(text, 1, place)[0]
        stiffness = {key: value for key, value in values.items() if key in _CONTACT}
        if stiffness:
            self._stiffness.setdefault(link, {}).update(stiffness)
        mu = values.get("mu1", values.get("mu"))
        if mu is not None:
            self._friction[link] = max(0.0, mu)
            if values.get("mu2", mu) != mu:
                self._uneven.append(f"gazebo '{link}': <mu2> is taken to be <mu1>, {mu:g}")
        self._direction(gazebo, link)
        name = gazebo.findtext("material")
        if name and name.strip():
            colour = gazebo_colour(name)
            if colour is None:
                self._xml.note(f"gazebo '{link}': material '{name.strip()}' has no known colour")
            else:
                self._colours[link] = colour

    def _direction(self, gazebo: Element, link: str) -> None:
        """Keep which way a link's friction acts, where that lies in the ground."""
        text = gazebo.findtext("fdir1") or ""
        if text.strip():
            x, y, z = self._xml.numbers(text, 3, f"gazebo '{link}' <fdir1>")
            length = math.hypot(x, y)
            if length > abs(z):
                self._grips[link] = (x / length, y / length)

    def _plugin(self, plugin: Element, link: str | None) -> None:
        controlled = drive_of_controllers(self._xml, plugin) if is_control(plugin) else None
        drive = read_drive(self._xml, plugin if controlled is None else controlled, self._urdf)
        name = plugin.get("name") or plugin.get("filename") or "?"
        kind = drive_kind(plugin if controlled is None else controlled)
        if drive is not None and self._drive is not None:
            self._xml.note(f"plugin '{name}': a second drive is not simulated", NoteKind.IGNORED)
        elif drive is not None:
            self._drive, self._kind = drive, kind
        elif kind is not None:
            self._kind, self._told = self._kind or kind, read_told(self._xml, plugin, kind)
        elif text_of(plugin, "bodyname", "bodyid") in self._urdf.links and "imu" in _kind(plugin):
            self._sensors.append(imu_plugin(self._xml, plugin))
        else:
            self._other_plugin(plugin, name, link)

    def _other_plugin(self, plugin: Element, name: str, link: str | None) -> None:
        """Say what stands in for a plugin, or that nothing does."""
        kind, sensor = _kind(plugin), sensor_type(plugin)
        if sensor:
            self._xml.note(
                f"plugin '{name}': stands outside <sensor>, so that it makes none, as in Gazebo:"
                f" {self._cure(sensor, link or text_of(plugin, 'framename'))}",
                NoteKind.BROKEN,
            )
        elif "jointstate" in kind:
            self._xml.note(f"plugin '{name}': all moving joints are published, each tick")
        elif is_control(plugin):
            self._xml.note(f"plugin '{name}': its controllers move no wheels of two sides")
        elif "p3d" in kind or "posepublisher" in kind or "odometrypublisher" in kind:
            self._xml.note(f"plugin '{name}': the true pose is published on ground_truth/odom")
        else:
            self._xml.note(f"plugin '{name}': not simulated", NoteKind.IGNORED)

    def _cure(self, sensor: str, link: str) -> str:
        """Return where what belongs into a sensor goes."""
        named = link if link in self._urdf.links else "LINK"
        return f'put it into <gazebo reference="{named}"><sensor type="{sensor}" name="NAME">'

    def _sensor(self, sensor: Element, link: str) -> None:
        """Read a sensor, of which there may be any number of each kind."""
        kind, place = sensor.get("type", "?"), place_of(sensor)
        if kind not in KINDS:
            valid = ", ".join(KINDS)
            self._xml.note(
                f"{place}: type '{kind}' is not simulated; simulated are {valid}", NoteKind.IGNORED
            )
        elif link not in self._urdf.links:
            self._xml.note(f"{place}: not simulated, since '{link}' is no link", NoteKind.IGNORED)
        else:
            self._sensors += KINDS[kind](self._xml, sensor, link)

    def settings(self) -> GazeboSettings:
        """Return what was read."""
        for tag, links in self._left_out.items():
            names = ", ".join(sorted({name for name in links if name}))
            where = f" (at {names})" if names else ""
            self._xml.note(f"gazebo <{tag}>{where}: not simulated", NoteKind.IGNORED)
        found = settle(self._xml, self._sensors)
        return GazeboSettings(
            self._drive,
            found.lidar,
            found.camera,
            found.imu,
            self._friction,
            self._colours,
            self._kind,
            self._stiffness,
            found.further,
            self._grips,
            tuple(self._uneven),
            self._told,
        )
