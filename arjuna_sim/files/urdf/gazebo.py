"""Reading a URDF's Gazebo tags and the joints that it hands to controllers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_sim.files.robots.gazebo import remedy
from arjuna_sim.files.sensor_tag import PluginTag, SensorTag, Tags
from arjuna_sim.files.tag_text import gazebo_colour, is_true, plain, texts
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Urdf

_CONTACT = ("kp", "kd")
_BELOW_SENSOR = {"ray": "ray", "lidar": "gpu_lidar", "camera": "camera", "imu": "imu"}
"""Tags that describe a sensor, and its type."""
_SURFACE = "collision/surface//"
"""Where SDF has a surface's tags, which Gazebo merges into the link's own."""
_SPRING = {"springstiffness": "stiffness", "springreference": "spring_at"}
_NO_MATTER = ("preservefixedjoint", "providefeedback", "implicitspringdamper")
_READ = (
    *_SPRING,
    *_NO_MATTER,
    "fdir1",
    "sensor",
    "plugin",
    "mu1",
    "mu",
    "material",
    "visual",
    "mu2",
    *_CONTACT,
)


def read_tags(xml: XmlFile, urdf: Urdf) -> Tags:
    """Return a URDF's tags; those that are not understood become notes.

    Raises:
        RobotError: A value is invalid.
    """
    tags, left_out = Tags(controlled=set(_controlled(xml.root))), dict[str, list[str]]()
    for gazebo in xml.root.findall("gazebo"):
        link = gazebo.get("reference")
        if link is not None and link not in urdf.links and link not in urdf.joints:
            problem = f"reference '{link}' does not exist; {nearest(link, urdf.links)}"
            xml.note(f"gazebo {problem}; what it says is left out", NoteKind.MISSING)
            continue
        tags.items += [PluginTag(plugin, link) for plugin in gazebo.findall("plugin")]
        sensors = gazebo.findall("sensor")
        tags.items += [SensorTag(xml, sensor, link or urdf.root) for sensor in sensors]
        if link in urdf.joints:
            springs = tags.springs.setdefault(link, {})
            for child in gazebo:
                if (key := _SPRING.get(plain(child.tag))) is not None:
                    label = f"gazebo '{link}' {child.tag}"
                    springs[key] = xml.numbers(child.text or "", 1, label)[0]
        if link is not None:
            _read_surface(xml, gazebo, link, tags)
        for child in gazebo:
            if child.tag in _BELOW_SENSOR:
                xml.note(
                    f"gazebo <{child.tag}>: stands outside <sensor>, so that there is none:"
                    f" {remedy(urdf, _BELOW_SENSOR[child.tag], link or '')}",
                    NoteKind.BROKEN,
                )
                continue
            is_default = plain(child.tag) == "gravity" and is_true(child.text)
            is_surface = child.tag == "collision" and child.find("surface") is not None
            if plain(child.tag) not in _READ and not is_default and not is_surface:
                left_out.setdefault(child.tag, []).append(link or "")
    for tag, links in left_out.items():
        names = ", ".join(sorted({name for name in links if name}))
        where = f" (at {names})" if names else ""
        xml.note(f"gazebo <{tag}>{where}: not simulated", NoteKind.IGNORED)
    return tags


def _read_surface(xml: XmlFile, gazebo: Element, link: str, tags: Tags) -> None:
    values = {}
    for child in (*gazebo, *gazebo.iterfind(f"{_SURFACE}*")):
        if plain(child.tag) in ("mu1", "mu", "mu2", *_CONTACT):
            label = f"gazebo '{link}' {child.tag}"
            text = (child.text or "").strip() or child.get("value", "")
            if not text:
                xml.note(f"{label}: is empty, so it is left out", NoteKind.BROKEN)
                continue
            values[plain(child.tag)] = xml.numbers(text, 1, label)[0]
    stiffness = {key: value for key, value in values.items() if key in _CONTACT}
    if stiffness:
        tags.stiffness.setdefault(link, {}).update(stiffness)
    mu = values.get("mu1", values.get("mu"))
    if mu is not None:
        tags.friction[link] = max(0.0, mu)
        if values.get("mu2", mu) != mu:
            tags.uneven.append(f"gazebo '{link}': <mu2> is taken to be <mu1>, {mu:g}")
    text = gazebo.findtext("fdir1") or gazebo.findtext(f"{_SURFACE}fdir1") or ""
    if text.strip():
        x, y, z = xml.numbers(text, 3, f"gazebo '{link}' <fdir1>")
        length = math.hypot(x, y)
        if length > abs(z):
            tags.grips[link] = (x / length, y / length)
    name = (gazebo.findtext("material") or "").strip()
    colour = gazebo_colour(name) if name else None
    if colour is not None:
        tags.colours[link] = colour
    elif name:
        xml.note(f"gazebo '{link}': material '{name}' has no known colour")


def _controlled(root: Element) -> Iterator[str]:
    for transmission in root.iter("transmission"):
        for joint in transmission.iter("joint"):
            if any("Velocity" in text for text in texts(transmission, "hardwareinterface")):
                yield joint.get("name", "")
    for control in root.iter("ros2_control"):
        for joint in control.iter("joint"):
            if joint.find("command_interface[@name='velocity']") is not None:
                yield joint.get("name", "")
