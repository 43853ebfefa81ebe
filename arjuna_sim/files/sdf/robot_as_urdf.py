"""A robot of an SDF model, told as URDF: what loads, stands, drives and is described is one form.

Links keep their names, those of nested models as `model/link`; sensors, plugins and friction become
Gazebo tags.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement, tostring  # nothing is parsed here

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.frames import MERGE, Scope
from arjuna_sim.files.sdf.includes import Includes
from arjuna_sim.files.sdf.robot_parts import (
    numbers_text,
    tell_inertial,
    tell_origin,
    tell_part,
)
from arjuna_sim.files.sdf.surface_tags import read_friction
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind

_MOVING = ("revolute", "continuous", "prismatic")
_UNLIMITED = 1e6  # [rad or m]
_WORLD = "world"


@dataclass(frozen=True)
class _Model:
    """A model of the robot: its file, its frames, where it stands and how its links are called."""

    xml: XmlFile
    element: Element
    scope: Scope
    T: Pose3
    prefix: str

    def called(self, name: str) -> str:
        """Return the name in the robot of a link that this model names."""
        return name if name == _WORLD else self.prefix + name.strip().replace("::", "/")

    def joint_pose(self, joint: Element) -> Pose3:
        """Return where a joint is in the robot."""
        child = (joint.findtext("child") or "").strip()
        base = ORIGIN if child == _WORLD else self.scope.find(child)
        return self.T @ self.scope.pose(joint, f"joint '{joint.get('name', '?')}'", base)

    def axis_pose(self, joint: Element) -> Pose3:
        """Return the frame in the robot that a joint's axis is told in."""
        T_joint = self.T.inverse() @ self.joint_pose(joint)
        axis = self.xml.child(joint, "axis", f"joint '{joint.get('name', '?')}'")
        return self.T @ self.scope.axis(axis, T_joint)

    def plugin(self, element: Element) -> Element:
        """Return a plugin with the names that this model's joints have in the robot."""
        told = copy.deepcopy(element)
        own = {joint.get("name", "") for joint in self.element.findall("joint")}
        for tag in told.iter():
            if (tag.text or "").strip() in own:
                tag.text = self.called(tag.text or "")
        return told


@dataclass
class _Told:
    """What was told so far: where links are in the robot, and who carries them."""

    root: Element
    places: dict[str, Pose3] = field(default_factory=dict)
    carried: dict[str, str] = field(default_factory=dict)


def robot_as_urdf(xml: XmlFile) -> bytes:
    """Return the robot of a parsed SDF file as URDF.

    Args:
        xml: The file; what is not told is noted there.

    Raises:
        RobotError: It holds no model, or a value is invalid.
    """
    includes = Includes(xml)
    includes.expand(xml, xml.root)
    model = xml.root.find("model")
    if model is None:
        raise RobotError(xml.path, "is no robot: <sdf> must hold one <model>, and no <world>")
    told = _Told(Element("robot", name=xml.attribute(model, "name", "a model")))
    models = list(_models(xml, model, ORIGIN, "", includes))
    turning = {
        m.called((joint.findtext("child") or "").strip()): m.joint_pose(joint)
        for m in models
        for joint in m.element.findall("joint")
        if joint.get("type") in _MOVING
    }
    for m in models:
        for link in m.element.findall("link"):
            _link(m, link, turning, told)
        for frame in m.element.findall("frame"):
            _frame(m, frame, told)
        for plugin in m.element.findall("plugin"):
            SubElement(told.root, "gazebo").append(m.plugin(plugin))
    for m in models:
        for joint in m.element.findall("joint"):
            _joint(m, joint, told)
    _join_roots(xml, told)
    return bytes(tostring(told.root, encoding="utf-8", xml_declaration=True))


def _models(
    xml: XmlFile, model: Element, T: Pose3, prefix: str, includes: Includes
) -> Iterator[_Model]:
    """Yield a model, and those that are nested in it."""
    xml = includes.file_of(model, xml)
    place = f"model '{model.get('name', '?')}'"
    scope = Scope(xml, model, place)
    yield _Model(xml, model, scope, T, prefix)
    for nested in model.findall("model"):
        inner = prefix if nested.get(MERGE) == "true" else f"{prefix}{nested.get('name', '?')}/"
        yield from _models(xml, nested, T @ scope.pose(nested, place), inner, includes)


def _link(model: _Model, element: Element, turning: dict[str, Pose3], told: _Told) -> None:
    """Tell a link; one that a joint turns lies where its joint is, as URDF wants it."""
    xml, scope = model.xml, model.scope
    name = model.called(xml.attribute(element, "name", "a link"))
    place = f"link '{name}'"
    T_link = scope.pose(element, place)
    about = turning.get(name)
    true = model.T @ T_link
    told.places[name] = true if about is None else Pose3(about.position, true.quaternion)
    T_own = told.places[name].inverse() @ true
    link = SubElement(told.root, "link", name=name)
    inertial = element.find("inertial")
    if inertial is not None and inertial.find("mass") is not None:
        tell_inertial(xml, inertial, SubElement(link, "inertial"), T_own, place)
    gazebo = Element("gazebo", reference=name)
    for tag in ("collision", "visual"):
        for part in element.findall(tag):
            T = T_own @ T_link.inverse() @ scope.pose(part, f"{place} {tag}", T_link)
            tell_part(xml, part, T, link, f"{place} {tag}")
    for collision in element.findall("collision"):
        mu = read_friction(xml, collision, f"{place} collision")
        if mu is not None and gazebo.find("mu1") is None:
            SubElement(gazebo, "mu1").text = repr(mu)
    for sensor in element.findall("sensor"):
        own = copy.deepcopy(sensor)
        for pose in own.findall("pose"):
            own.remove(pose)
        T = T_own @ T_link.inverse() @ scope.pose(sensor, f"{place} sensor", T_link)
        if sensor.find("pose") is not None or T_own != ORIGIN:
            SubElement(own, "pose").text = numbers_text((*T.position, *T.rpy()))
        gazebo.append(own)
    if len(gazebo):
        told.root.append(gazebo)


def _frame(model: _Model, element: Element, told: _Told) -> None:
    """Tell a named frame as a link without a mass, fixed to what it is attached to."""
    own = element.get("name", "?")
    name, base = model.called(own), model.called(element.get("attached_to") or "")
    base = base if base in told.places else next(iter(told.places), "")
    if name in told.places or not base:
        return
    told.places[name] = model.T @ model.scope.find(own)
    SubElement(told.root, "link", name=name)
    _connect(told, f"{name}_frame", "fixed", base, name)


def _joint(model: _Model, element: Element, told: _Told) -> None:
    xml = model.xml
    name = model.called(xml.attribute(element, "name", "a joint"))
    place, kind = f"joint '{name}'", xml.attribute(element, "type", f"joint '{name}'")
    parent, child = (
        model.called((xml.child(element, tag, place).text or "").strip())
        for tag in ("parent", "child")
    )
    if parent == _WORLD and _WORLD not in told.places:
        told.places[_WORLD] = ORIGIN
        SubElement(told.root, "link", name=_WORLD)
    for end in (parent, child):
        if end not in told.places:
            raise xml.fail(place, f"link '{end}' does not exist")
    if child in told.carried:
        xml.note(f"{place}: closes a loop of links, so it is left out", NoteKind.UNSUPPORTED)
        return
    if kind not in (*_MOVING, "fixed"):
        xml.note(f"{place}: type '{kind}' is held fast", NoteKind.UNSUPPORTED)
    if kind not in _MOVING:
        _connect(told, name, "fixed", parent, child)
        return
    joint = _connect(told, name, kind, parent, child)
    _moving(xml, element, joint, (model.axis_pose(element), told.places[child]))


def _moving(xml: XmlFile, element: Element, joint: Element, where: tuple[Pose3, Pose3]) -> None:
    """Tell a joint's axis, limits, damping and what it follows."""
    T_axis, T_child = where
    place = f"joint '{joint.get('name')}'"
    axis = xml.child(element, "axis", place)
    tag = xml.child(axis, "xyz", place)
    turned = T_axis.rotation() @ xml.numbers(tag.text or "", 3, f"{place} <xyz>")
    SubElement(joint, "axis", xyz=numbers_text(T_child.rotation().T @ turned))
    low = xml.number(axis, "limit/lower", -_UNLIMITED, place)
    high = xml.number(axis, "limit/upper", _UNLIMITED, place)
    limit = {"velocity": axis.findtext("limit/velocity", "0").strip()}
    if joint.get("type") == "revolute" and low <= -_UNLIMITED and high >= _UNLIMITED:
        joint.set("type", "continuous")
    elif joint.get("type") != "continuous":
        limit |= {"lower": repr(low), "upper": repr(high), "effort": "0"}
    SubElement(joint, "limit", limit)
    keys = ("damping", "friction")
    values = {key: max(0.0, xml.number(axis, f"dynamics/{key}", 0.0, place)) for key in keys}
    SubElement(joint, "dynamics", {key: repr(value) for key, value in values.items()})
    mimic = axis.find("mimic")
    if mimic is not None:
        multiplier = xml.number(mimic, "multiplier", 1.0, place)
        offset = xml.number(mimic, "offset", 0.0, place)
        offset -= multiplier * xml.number(mimic, "reference", 0.0, place)
        told_mimic = {"joint": mimic.get("joint", ""), "multiplier": repr(multiplier)}
        SubElement(joint, "mimic", told_mimic | {"offset": repr(offset)})


def _connect(told: _Told, name: str, kind: str, parent: str, child: str) -> Element:
    """Tell a joint between two links, where they stand."""
    joint = SubElement(told.root, "joint", name=name, type=kind)
    tell_origin(joint, told.places[parent].inverse() @ told.places[child])
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    told.carried[child] = parent
    return joint


def _join_roots(xml: XmlFile, told: _Told) -> None:
    """Fix links that no joint carries to the one that carries most."""
    roots = [name for name in told.places if name not in told.carried]
    count = dict.fromkeys(roots, 0)
    for name in told.places:
        for top in _above(told, name):
            if top in count:
                count[top] += 1
    root = max(roots, key=lambda name: (name == _WORLD, count[name]), default="")
    for other in roots:
        if other != root:
            xml.note(f"link '{other}': no joint carries it: it is fixed to '{root}'")
            _connect(told, f"{other}_fixed", "fixed", root, other)


def _above(told: _Told, name: str) -> Iterator[str]:
    """Yield a link and those that carry it, as far as they form no circle."""
    for _ in range(len(told.places)):
        yield name
        if name not in told.carried:
            return
        name = told.carried[name]
