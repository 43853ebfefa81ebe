"""Poses in SDF, which may be relative to any named frame, link, joint or model.

Source: SDFormat, Pose Frame Semantics Proposal (versions 1.7 and later).
"""

from __future__ import annotations

import math
import re
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import nearest
from arjuna_core.files.xml_text import DEPTH_MAX
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.tag_text import is_true
from arjuna_sim.files.xml_file import XmlFile

_NAMED = ("link", "model", "include", "joint", "frame")
"""Tags of what a pose can be relative to; of two that share a name the first is meant, as a joint
may be called as its link is before SDF 1.7.
"""
MERGE = "merge"
"""Attribute of an included model whose links and frames are those of the model around it."""
_OWN = ("__model__", "__root__", "world", "")
_VERSION = re.compile(r"1\.([0-4])")
"""Versions in which an axis is in its model's frame, not yet in its joint's."""


def raw_pose(xml: XmlFile, element: Element, label: str) -> Pose3:
    """Return the numbers of an element's `<pose>`, the origin where it has none.

    Raises:
        WorldError: They are no pose.
    """
    pose = element.find("pose")
    text = "" if pose is None else (pose.text or "").strip()
    if pose is None or not text:
        return ORIGIN
    if pose.get("rotation_format") == "quat_xyzw":
        x, y, z, *quaternion = xml.numbers(text, 7, f"{label} pose")
        return _of_quaternion(xml, (x, y, z), quaternion, label)
    numbers = xml.numbers(text, 6, f"{label} pose")
    xml.position(" ".join(map(str, numbers[:3])), f"{label} pose")
    angles = numbers[3:]
    if pose.get("degrees") == "true":
        angles = tuple(math.radians(angle) for angle in angles)
    return Pose3.from_rpy(numbers[:3], angles)


def _of_quaternion(
    xml: XmlFile, position: tuple[float, float, float], quaternion: list[float], label: str
) -> Pose3:
    x, y, z, w = quaternion
    length = math.hypot(x, y, z, w)
    if not 0.0 < length < math.inf:
        raise xml.fail(f"{label} pose", "its quaternion is no rotation")
    return Pose3(position, (w / length, x / length, y / length, z / length))


def base_of(element: Element) -> str:
    """Return the name of the frame that an element's pose is relative to, "" for its parent."""
    pose = element.find("pose")
    if pose is None:
        return ""
    return (pose.get("relative_to") or pose.get("frame") or "").strip()


class Scope:
    """The frames of one model or world."""

    def __init__(self, xml: XmlFile, element: Element, label: str) -> None:
        self._xml = xml
        self._label = label
        self._items: dict[str, Element] = {}
        for child in (child for tag in _NAMED for child in element.findall(tag)):
            self._items.setdefault(_name(child), child)
        self._is_old = _VERSION.fullmatch(xml.root.get("version", "")) is not None
        merged = [child for child in element if child.get(MERGE) == "true"]
        self._merged = {
            _name(inner): child for child in merged for inner in child if inner.tag in _NAMED
        }

    def pose(
        self, element: Element, label: str, parent: Pose3 = ORIGIN, seen: tuple[str, ...] = ()
    ) -> Pose3:
        """Return an element's pose in this scope.

        Args:
            parent: What the pose is relative to, where it does not say.
            seen: The frames whose poses are relative to it.

        Raises:
            WorldError: It is relative to what does not exist, or to itself.
        """
        base = base_of(element)
        return (self.find(base, seen) if base else parent) @ raw_pose(self._xml, element, label)

    def in_link(self, element: Element, label: str, T_link: Pose3) -> Pose3:
        """Return the pose in this scope of a part of a link.

        One that is relative to what does not exist is in its link, with a note, as in Gazebo.

        Raises:
            WorldError: It is no pose, or relative to itself.
        """
        base = base_of(element)
        if not base or base in _OWN or self._holds(base):
            return self.pose(element, label, T_link)
        problem = f"is relative to '{base}', which does not exist: its pose is in its link"
        self._xml.note(f"{label}: {problem}")
        return T_link @ raw_pose(self._xml, element, label)

    def _holds(self, name: str) -> bool:
        first = name.partition("::")[0]
        return not {name, first}.isdisjoint(self._items) or first in self._merged

    def axis(self, axis: Element, T_joint: Pose3) -> Pose3:
        """Return the pose of the frame that the numbers of a joint's `<axis>` are in.

        Raises:
            WorldError: It does not exist.
        """
        tag = axis.find("xyz")
        named = "" if tag is None else tag.get("expressed_in", "").strip()
        if named:
            return self.find(named)
        in_model = is_true(axis.findtext("use_parent_model_frame"))
        return ORIGIN if in_model or self._is_old else T_joint

    def find(self, name: str, seen: tuple[str, ...] = ()) -> Pose3:
        """Return the pose of a named thing in this scope; `seen` as in `pose`.

        Raises:
            WorldError: It does not exist, or its pose is relative to itself.
        """
        if name in _OWN:
            return ORIGIN
        if name in seen:
            problem = f"frame '{name}' is relative to itself: {' -> '.join((*seen, name))}"
            raise self._xml.fail(self._label, problem)
        if len(seen) > DEPTH_MAX:
            problem = f"frame '{name}' ends a chain of more than {DEPTH_MAX} frames"
            raise self._xml.fail(self._label, problem)
        first, _, rest = name.partition("::")
        element = self._items.get(name) if name in self._items else self._items.get(first)
        merged = None if element is not None else self._merged.get(first)
        if merged is not None:
            T_own = self.pose(merged, f"{self._label} '{name}'", ORIGIN, (*seen, name))
            return T_own @ Scope(self._xml, merged, self._label).find(name)
        if element is None:
            problem = f"frame '{name}' does not exist; {nearest(name, self._items)}"
            raise self._xml.fail(self._label, problem)
        seen = (*seen, name)
        parent = ORIGIN if base_of(element) else self._parent(element, seen)
        pose = self.pose(element, f"{self._label} '{name}'", parent, seen)
        if rest and name not in self._items and element.tag == "model":
            return pose @ Scope(self._xml, element, f"{self._label} '{first}'").find(rest)
        return pose

    def _parent(self, element: Element, seen: tuple[str, ...]) -> Pose3:
        attached = ""
        if element.tag == "frame":
            attached = (element.get("attached_to") or "").strip()
        elif element.tag == "joint":
            attached = (element.findtext("child") or "").strip()
        return self.find(attached, seen) if attached else ORIGIN


def _name(element: Element) -> str:
    return (
        (element.findtext("name") or "").strip()
        if element.tag == "include"
        else element.get("name", "").strip()
    )
