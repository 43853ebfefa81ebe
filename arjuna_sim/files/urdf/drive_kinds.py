"""Saying plainly which drives are simulated as others: holonomic and steered ones."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.urdf.gazebo_text import plain
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.settings import DriveSettings
from arjuna_sim.model.urdf import Urdf

_SIDEWAYS = "drives as a skid-steer, by the wheels of its two sides; it does not move sideways"
_STEERED = "drives by the wheels of its two sides at different speeds; its steering does not turn"
_PLUGINS = {
    "mecanum": f"has mecanum wheels: it {_SIDEWAYS}",
    "omni": f"has omni wheels: it {_SIDEWAYS}",
    "planarmove": f"moves in the plane: it {_SIDEWAYS}",
    "velocitycontrol": f"moves in the plane: it {_SIDEWAYS}",
    "ackermann": f"steers: it {_STEERED}",
    "tricycle": f"steers: it {_STEERED}",
    "bicycle": f"steers: it {_STEERED}",
    "steering": f"steers: it {_STEERED}",
}
_PLANAR = ("planarmove", "velocitycontrol")
_STEERS = re.compile(r"steer|kingpin|knuckle", re.I)
_LEVEL = 0.7  # least part of a steering axis along z


def plugin_kind(plugin: Element) -> str:
    """Return the kind of drive that a plugin is, of those simulated otherwise; "" for another."""
    named = plain(plugin.get("filename", "") + plugin.get("name", "")).replace("-", "")
    return next((kind for kind in _PLUGINS if kind in named), "")


def is_planar(kind: str) -> bool:
    """Tell whether a plugin of a kind moves the robot itself, without its wheels' help."""
    return kind in _PLANAR


def note_kind(xml: XmlFile, name: str, kind: str) -> None:
    """Note how a plugin's drive is simulated, where it is one of those."""
    if kind:
        xml.note(f"plugin '{name}': {_PLUGINS[kind]}")


def note_guess(xml: XmlFile, urdf: Urdf, drive: DriveSettings) -> None:
    """Note a guessed drive whose links say that it is another."""
    children = [urdf.joints[name].child for name in drive.wheels]
    names = " ".join((urdf.name, *drive.wheels, *children)).lower()
    kind = next((kind for kind in ("mecanum", "omni") if drive.wheels and kind in names), "")
    if not kind and drive.wheels and _steers(urdf):
        kind = "ackermann"
    if kind:
        xml.note(_PLUGINS[kind])


def _steers(urdf: Urdf) -> bool:
    """Tell whether a joint turns a wheel about the vertical."""
    carriers = {joint.parent for joint in urdf.joints.values() if joint.kind == "continuous"}
    return any(
        joint.kind == "revolute"
        and joint.child in carriers
        and _STEERS.search(f"{joint.name} {joint.child}") is not None
        and abs(float((urdf.T_root(joint.child).rotation() @ joint.axis)[2])) > _LEVEL
        for joint in urdf.joints.values()
    )
