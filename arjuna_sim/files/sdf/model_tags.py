"""Reading SDF's models: links and joints of all that is nested in one, as plain values."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.pictures import dressed
from arjuna_sim.files.sdf.frames import MERGE, Scope
from arjuna_sim.files.sdf.geometry_tags import read_colour, read_friction, read_shape
from arjuna_sim.files.sdf.includes import ExcessError, Includes, leaving_out
from arjuna_sim.files.sdf.look_tags import read_light
from arjuna_sim.files.tag_text import OWN, PATH, is_true
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Part, volume_of
from arjuna_sim.model.look import Light
from arjuna_sim.model.notes import NoteKind

PARTS_MAX = 60_000
_OF_MODEL = (
    *("link", "model", "include", "pose", "static", "frame", "joint", "plugin", "self_collide"),
    "ros2_control",
    *("allow_auto_disable", "enable_wind", "placement_frame"),
)
_OF_LINK = (
    *("collision", "visual", "pose", "inertial", "gravity", "self_collide", "kinematic", "light"),
    *("velocity_decay", "enable_wind", "audio_source", "must_be_base_link", "sensor"),
)
_PLACED = ("collision", "visual", "inertial", "joint", "sensor")
SWINGING = ("revolute", "continuous", "prismatic")
"""Kinds of joints that let a link move about or along one axis."""
WORLD = "world"
"""Name of the world as the parent of a joint."""


@dataclass
class SdfLink:
    """A link of a model, or of one that is nested in it.

    Attributes:
        name: Path from the model of the world, such as `lamp::shade`.
        static: Whether the model that it is of stands fast.
        floats: Whether gravity leaves it alone.
        mass: What the file says; None where it says nothing [kg].
        solid: What stops robots and rays, in the world.
        drawn: What is only seen, in the world.
        sensors: The tags of its sensors and their poses in the world.
        lights: Its lights, in the world.
        self_collides: Whether it touches other links of its model.
    """

    element: Element
    file: XmlFile
    name: str
    T_world: Pose3
    static: bool
    floats: bool
    mass: float | None
    solid: list[Part] = field(default_factory=list)
    drawn: list[Part] = field(default_factory=list)
    sensors: list[tuple[Element, Pose3]] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    self_collides: bool = False


@dataclass(frozen=True)
class SdfJoint:
    """A joint of a model.

    Attributes:
        prefix: Path of its model, before the names of links and joints.
        parent: Path of a link, or `world`.
        child: Path of a link, or `world`.
        T_world: Where it is.
        T_axes: The frames of its `<axis>` and its `<axis2>`, as far as it has them.
    """

    element: Element
    file: XmlFile
    prefix: str
    kind: str
    parent: str
    child: str
    T_world: Pose3
    T_axes: tuple[Pose3, ...]

    @property
    def name(self) -> str:
        """Its path from the model of the world."""
        return self.prefix + self.element.get("name", "?")

    def dynamics(self, axis: Element) -> dict[str, Any]:
        """Return its damping, its dry friction and its spring, none of which pushes."""
        label = f"joint '{self.element.get('name', '?')}'"
        damping, friction, stiffness, spring_at = (
            self.file.number(axis, f"dynamics/{tag}", 0.0, label)
            for tag in ("damping", "friction", "spring_stiffness", "spring_reference")
        )
        found = {"damping": damping, "friction": friction, "stiffness": stiffness}
        return {**{key: max(0.0, each) for key, each in found.items()}, "spring_at": spring_at}


class ModelReader:
    """Reads the models of a world, or that of a robot.

    Args:
        is_robot: Whether a robot is read: a broken link or joint is refused rather than left out,
            and frames, sensors and plugins are kept.

    Attributes:
        frames: Path, path of the frame that it is attached to, and pose of each `<frame>`.
        plugins: The plugins, with the paths of joints and links that they name.
    """

    def __init__(self, includes: Includes, is_robot: bool = False) -> None:
        self._includes = includes
        self._is_robot = is_robot
        self._parts = 0
        self.frames: list[tuple[str, str, Pose3]] = []
        self.plugins: list[Element] = []

    def _leaving_out(self, xml: XmlFile, what: str) -> AbstractContextManager[None]:
        return nullcontext() if self._is_robot else leaving_out(xml, what)

    def read(
        self, xml: XmlFile, model: Element, pose: Pose3, placed: bool = False
    ) -> tuple[list[SdfLink], list[SdfJoint]]:
        """Return the links and joints of a model that stands at a pose in the world.

        Args:
            pose: Of the model, or of its placement frame.
            placed: Whether the pose is surely the model's own.

        Raises:
            ExcessError: There are too many parts.
            WorldError: Its placement frame is none.
        """
        self._links: list[SdfLink] = []
        self._joints: list[SdfJoint] = []
        self._model(xml, model, pose, placed)
        return self._links, self._joints

    def _model(
        self,
        xml: XmlFile,
        model: Element,
        pose: Pose3,
        placed: bool = False,
        prefix: str = "",
        static: bool = False,
    ) -> None:
        xml = self._includes.file_of(model, xml)
        label = f"model '{model.get('name', '?')}'"
        scope = Scope(xml, model, label)
        T_world = pose if placed else own_pose(model, scope, pose)
        static = static or is_static(model)
        for tag in sorted({child.tag for child in model} - set(_OF_MODEL)):
            xml.note(f"{label}: <{tag}>: not simulated", NoteKind.IGNORED)
        tags = [tag for tag in _PLACED if model.find(f".//{tag}[origin]") is not None]
        if tags:
            where = ", ".join(f"<{tag}>" for tag in tags)
            text = f"{label}: <origin> of {where}: no tag of SDF, and left out, as Gazebo does"
            xml.note(f"{text}; <pose> places it", NoteKind.IGNORED)
        for link in model.findall("link"):
            with self._leaving_out(xml, f"{label} link '{link.get('name', '?')}'"):
                of = prefix, label, static, model
                self._links.append(self._link(xml, link, scope, T_world, of))
        for joint in model.findall("joint"):
            with self._leaving_out(xml, f"{label} joint '{joint.get('name', '?')}'"):
                self._joints.append(read_joint(xml, joint, scope, T_world, prefix))
        for nested in model.findall("model"):
            name = nested.get("name", "?")
            with self._leaving_out(xml, f"{label} model '{name}'"):
                T_nested = T_world @ scope.pose(nested, label)
                inner = prefix if nested.get(MERGE) == "true" else f"{prefix}{name}::"
                self._model(xml, nested, T_nested, prefix=inner, static=static)
        if self._is_robot:
            self._keep_frames_and_plugins(model, scope, T_world, prefix)

    def _keep_frames_and_plugins(
        self, model: Element, scope: Scope, T_world: Pose3, prefix: str
    ) -> None:
        for frame in model.findall("frame"):
            name, base = frame.get("name", "?"), frame.get("attached_to") or ""
            self.frames.append((prefix + name, prefix + base, T_world @ scope.find(name)))
        own = {part.get("name", "") for part in model if part.tag in ("joint", "link")}
        path = prefix.replace("::", "/")
        for plugin in model.findall("plugin"):
            for tag in plugin.iter() if prefix else ():
                if (tag.text or "").strip() in own:
                    tag.text = f"{path}{(tag.text or '').strip()}"
            plugin.attrib |= {PATH: path, OWN: "\n".join(own)} if prefix else {}
            self.plugins.append(plugin)
        for joint in model.iterfind("ros2_control/joint") if prefix else ():
            name = joint.get("name", "")
            joint.set("name", f"{path}{name}" if name in own else name)

    def _link(
        self,
        xml: XmlFile,
        link: Element,
        scope: Scope,
        T_model: Pose3,
        of: tuple[str, str, bool, Element],
    ) -> SdfLink:
        prefix, label, static, model = of
        T_model_link = scope.pose(link, f"{label} link")
        for tag in sorted({child.tag for child in link} - set(_OF_LINK)):
            xml.note(f"{label}: <{tag}>: not simulated", NoteKind.IGNORED)
        floats = not is_true(link.findtext("gravity") or "true")
        floats = floats or is_true(link.findtext("kinematic"))
        touches = is_true(link.findtext("self_collide") or model.findtext("self_collide"))
        text = link.findtext("inertial/mass") or ""
        mass = xml.numbers(text, 1, f"{label} <mass>")[0] if text.strip() else None
        name = prefix + link.get("name", "?").strip()
        read = SdfLink(link, xml, name, T_model @ T_model_link, static, floats, mass)
        read.self_collides = touches
        if self._is_robot:
            label = f"link '{name.replace('::', '/')}'"
        self._hang(read, label, scope, T_model, T_model_link)
        weighed = 0.0
        for tag, parts in (("collision", read.solid), ("visual", read.drawn)):
            refuses = self._is_robot and tag == "collision"
            for element in link.findall(tag):
                if _is_ghost(element):
                    continue
                self._tally(xml, f"{label} {tag}")
                with nullcontext() if refuses else leaving_out(xml, f"{label} {tag}"):
                    own = _parts(xml, element, f"{label} {tag}", scope, T_model, T_model_link)
                    parts += own
                    if tag == "collision":
                        weighed += volume_of(own) * _density(xml, element, link, label)
        if read.solid and not read.drawn and _has_look(link):
            xml.note(f"{label}: its <collision> is drawn, as no <visual> of it can be")
            read.drawn += read.solid
        inertial = link.find("inertial")
        if inertial is not None and is_true(inertial.get("auto")) and weighed > 0.0:
            read = replace(read, mass=weighed)
        return read

    def _hang(
        self, read: SdfLink, label: str, scope: Scope, T_model: Pose3, T_model_link: Pose3
    ) -> None:
        """Read the sensors and lights of a link."""
        xml = read.file
        for sensor in read.element.findall("sensor"):
            with self._leaving_out(xml, f"{label} sensor"):
                pose = scope.in_link(sensor, f"{label} sensor", T_model_link)
                read.sensors.append((sensor, T_model @ pose))
        for light in read.element.findall("light"):
            with leaving_out(xml, f"{label} light"):
                pose = scope.in_link(light, f"{label} light", T_model_link)
                read.lights += read_light(xml, light, T_model @ pose)

    def _tally(self, xml: XmlFile, label: str) -> None:
        self._parts += 1
        if self._parts > PARTS_MAX:
            problem = f"is one of too many; valid: up to {PARTS_MAX} parts"
            raise ExcessError(xml.path, problem, label)


def _has_look(link: Element) -> bool:
    """Return whether something of a link is to be drawn, by its file."""
    shapes = [shape.tag for shape in link.iterfind("visual/geometry/*")]
    return bool(shapes) and "empty" not in shapes


def _is_ghost(collision: Element) -> bool:
    """Return whether a collision touches nothing: it has no bit in common with others, or says so.

    All others have all bits, unless they have none either.
    """
    contact = collision.find("surface/contact")
    if contact is None:
        return False
    bits = re.fullmatch(
        r"\s*0(x0+|0*)\s*", contact.findtext("collide_bitmask") or "", re.IGNORECASE
    )
    return bits is not None or is_true(contact.findtext("collide_without_contact"))


def _density(xml: XmlFile, collision: Element, link: Element, label: str) -> float:
    """Return the density of a collision by which SDF weighs its link [kg/m^3]."""
    of_link = xml.number(link.find("inertial"), "density", 1000.0, label)
    return max(0.0, xml.number(collision, "density", of_link, label))


def _parts(
    xml: XmlFile, element: Element, label: str, scope: Scope, T_world: Pose3, T_link: Pose3
) -> list[Part]:
    """Read a `<collision>` or `<visual>`; none (and a note) where its shape is left out."""
    read = read_shape(xml, xml.child(element, "geometry", label), label)
    if read is None:
        return []
    shape, T_own = read
    pose = T_world @ scope.in_link(element, label, T_link) @ T_own
    friction, colour = read_friction(xml, element, label), read_colour(xml, element, label)
    return dressed(xml, Part(shape, pose, colour, friction), element, label)


def own_pose(model: Element, scope: Scope, pose: Pose3) -> Pose3:
    """Return the pose of a model's own frame, where its pose is that of its placement frame.

    Raises:
        WorldError: Its placement frame is none.
    """
    frame = model.get("placement_frame", "")
    return pose @ scope.find(frame).inverse() if frame else pose


def is_static(model: Element) -> bool:
    """Return whether a model stands fast by its own tag."""
    return is_true(model.findtext("static"))


def read_joint(xml: XmlFile, joint: Element, scope: Scope, T_world: Pose3, prefix: str) -> SdfJoint:
    """Read a `<joint>` of a model, or of the world.

    Args:
        scope: The frames that it may name.
        T_world: Where those are.
        prefix: Of the links' paths.

    Raises:
        WorldError: An end is missing, or a frame does not exist.
    """
    label = f"joint '{joint.get('name', '?')}'"
    ends = []
    for tag in ("parent", "child"):
        element = xml.child(joint, tag, label)
        name = (element.text or element.findtext("link_name") or "").strip()
        ends.append(name if name == WORLD else prefix + name)
    child = (joint.findtext("child") or "").strip()
    base = scope.find(child) if child != WORLD else Pose3()
    pose, kind = scope.pose(joint, label, base), joint.get("type", "?")
    axes = (axis for tag in ("axis", "axis2") if (axis := joint.find(tag)) is not None)
    frames = tuple(T_world @ scope.axis(axis, pose) for axis in axes)
    return SdfJoint(joint, xml, prefix, kind, ends[0], ends[1], T_world @ pose, frames)


def parts_of(links: list[SdfLink]) -> Iterator[tuple[Part, bool]]:
    """Yield the parts of links, the solid ones of each before those that are only seen."""
    for link in links:
        yield from ((part, True) for part in link.solid)
        yield from ((part, False) for part in link.drawn)
