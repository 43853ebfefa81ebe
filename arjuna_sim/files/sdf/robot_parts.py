"""Parts of an SDF link, told as URDF: its mass, its shapes, and where they are."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement  # nothing is parsed here

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.sdf.geometry_tags import read_colour
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind

_SIZES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
}


def tell_inertial(xml: XmlFile, inertial: Element, link: Element, T_own: Pose3, place: str) -> None:
    """Tell an `<inertial>` of a link whose own frame is at a pose."""
    tell_origin(link, T_own @ raw_pose(xml, inertial, f"{place} inertial"))
    SubElement(link, "mass", value=(inertial.findtext("mass") or "").strip())
    tensor = inertial.find("inertia")
    if tensor is not None:
        keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        values = {key: (tensor.findtext(key) or "0").strip() for key in keys}
        SubElement(link, "inertia", values)


def tell_part(xml: XmlFile, part: Element, T: Pose3, link: Element, place: str) -> None:
    """Tell a `<collision>` or `<visual>`; a shape that URDF has not is left out with a note."""
    item = next(iter(xml.child(part, "geometry", place)), None)
    if item is None or item.tag not in (*_SIZES, "mesh"):
        if item is None or item.tag != "empty":
            shape = "an empty <geometry>" if item is None else f"<{item.tag}>"
            xml.note(f"{place}: {shape} is left out of a robot", NoteKind.UNSUPPORTED)
        return
    told = SubElement(link, part.tag, name=part.get("name", part.tag))
    tell_origin(told, T)
    geometry = SubElement(told, "geometry")
    if item.tag == "mesh":
        uri = (item.findtext("uri") or "").strip()
        found = xml.find(uri, place)
        name = uri if found is None else f"file://{found.resolve()}"
        scale = (item.findtext("scale") or "1 1 1").strip()
        SubElement(geometry, "mesh", filename=name, scale=scale)
    else:
        sizes = {key: (item.findtext(key) or "").strip() for key in _SIZES[item.tag]}
        SubElement(geometry, item.tag, sizes)
    if part.tag == "visual":
        material = SubElement(told, "material", name=f"{link.get('name')}/{len(link)}")
        SubElement(material, "color", rgba=numbers_text(read_colour(xml, part, place)))


def tell_origin(element: Element, T: Pose3) -> None:
    """Tell where an element is."""
    SubElement(element, "origin", xyz=numbers_text(T.position), rpy=numbers_text(T.rpy()))


def numbers_text(values: object) -> str:
    """Return numbers as URDF writes them."""
    return " ".join(repr(float(value)) for value in np.asarray(values).ravel())
