"""Reading a URDF: links, joints and shapes as plain values.

Ours, not yourdfpy: it imports trimesh (0.8 s or more), and checks neither numbers nor the tree, so
that all that follows here would stay; of 130 lines it would save the reading of 20 attributes.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import RobotError, nearest
from arjuna_sim.files.meshes.mesh_tag import mesh_shape
from arjuna_sim.files.urdf.inertial_tag import read_inertial
from arjuna_sim.files.urdf.joint_tags import check_mimics, read_joint, read_origin
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import GREY, Kind, Part, Shape
from arjuna_sim.model.joints import Joint
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Link, Urdf

_READ = ("link", "joint", "material", "gazebo", "transmission", "ros2_control")
_LINKS_MAX = 2000
_DEPTH_MAX = 100
_SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
}


def read_urdf(xml: XmlFile) -> Urdf:
    """Read links and joints.

    Args:
        xml: The file with the root `<robot>`.

    Raises:
        RobotError: Something is missing, not finite, not physical or no tree.
    """
    colours = _colours(xml)
    links = {}
    for tag in sorted({element.tag for element in xml.root} - set(_READ)):
        xml.note(f"<{tag}>: not simulated", NoteKind.IGNORED)
    if len(xml.root) > _LINKS_MAX * 4 or len(xml.root.findall("link")) > _LINKS_MAX:
        raise RobotError(xml.path, f"has too many parts; valid: up to {_LINKS_MAX} links")
    for element in xml.root.findall("link"):
        link = _link(xml, element, colours)
        if link.name in links:
            raise xml.fail(f"link '{link.name}'", "is there twice")
        links[link.name] = link
    joints = {}
    for element in xml.root.findall("joint"):
        joint = read_joint(xml, element, set(links))
        if joint.name in joints:
            raise xml.fail(f"joint '{joint.name}'", "is there twice")
        joints[joint.name] = joint
    joints = check_mimics(xml, joints)
    root = _root(xml, links, joints)
    name = xml.root.get("name", "robot")
    return Urdf(xml.path, name, xml.text.decode("utf-8", "replace"), root, links, joints)


def _colours(xml: XmlFile) -> dict[str, tuple[float, ...]]:
    result = {}
    for element in xml.root.iter("material"):
        color = element.find("color")
        if color is not None:
            place = f"material '{element.get('name', '')}'"
            text = xml.attribute(color, "rgba", place)
            result[element.get("name", "")] = xml.numbers(text, 4, place)
    return result


def _link(xml: XmlFile, element: Element, colours: dict[str, tuple[float, ...]]) -> Link:
    name = xml.attribute(element, "name", "a link")
    place = f"link '{name}'"
    parts: dict[str, list[Part]] = {"collision": [], "visual": []}
    for tag, found in parts.items():
        for child in element.findall(tag):
            shape = (_look if tag == "visual" else _shape)(xml, child, f"{place} {tag}")
            if shape is not None:
                material = child.find("material")
                colour = GREY if material is None else colours.get(material.get("name", ""), GREY)
                found.append(Part(shape, read_origin(xml, child, f"{place} {tag}"), colour))
    shapes = tuple(parts["collision"] or parts["visual"])
    inertial = read_inertial(xml, element, place, shapes)
    return Link(name, inertial, tuple(parts["collision"]), tuple(parts["visual"]))


def _look(xml: XmlFile, element: Element, place: str) -> Shape | None:
    """Read a shape that is only seen; None (and a note) where it is none."""
    try:
        return _shape(xml, element, place)
    except RobotError as error:
        xml.note(f"{error.place}: {error.problem}; it is left out", NoteKind.BROKEN)
        return None


def _shape(xml: XmlFile, element: Element, place: str) -> Shape | None:
    """Read a shape; None (and a note) for a mesh that is not simulated, or a shape of no size."""
    geometry = xml.child(element, "geometry", place)
    if len(geometry) != 1:
        raise xml.fail(place, f"<geometry> must hold one of {', '.join([*_SHAPES, 'mesh'])}")
    item = geometry[0]
    if item.tag == "mesh":
        name = xml.attribute(item, "filename", place)
        return mesh_shape(xml, name, item.get("scale", "1 1 1"), place)
    if item.tag not in _SHAPES:
        raise xml.fail(place, f"<{item.tag}> is unknown; {nearest(item.tag, [*_SHAPES, 'mesh'])}")
    size: tuple[float, ...] = ()
    for key in _SHAPES[item.tag]:
        count = 3 if key == "size" else 1
        text = xml.attribute(item, key, place)
        if 0.0 in xml.numbers(text, count, f"{place} {key}"):
            xml.note(f"{place}: a <{item.tag}> of no size is left out", NoteKind.BROKEN)
            return None
        size += xml.sizes(text, count, f"{place} {key}")
    kind = Kind.CYLINDER if item.tag == "capsule" else Kind(item.tag)
    if item.tag == "capsule":
        xml.note(f"{place}: the <capsule> is taken to be a cylinder")
    return Shape(kind, size)


def _root(xml: XmlFile, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """Return the one root of the tree that the joints span."""
    if not links:
        raise RobotError(xml.path, "has no links")
    parents: dict[str, str] = {}
    for joint in joints.values():
        if joint.child in parents:
            raise xml.fail(f"joint '{joint.name}'", f"link '{joint.child}' has two parents")
        parents[joint.child] = joint.parent
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        found = ", ".join(roots) or "none, the joints form a loop"
        raise RobotError(xml.path, f"must have one root link; it has: {found}")
    for start in links:
        link, steps = start, 0
        while link in parents:
            link, steps = parents[link], steps + 1
            if steps > len(links):
                raise xml.fail(f"link '{start}'", "the joints form a loop")
            if steps > _DEPTH_MAX:
                problem = f"hangs on more than {_DEPTH_MAX} others, one after the other"
                raise xml.fail(f"link '{start}'", problem)
    return roots[0]
