"""Writing a URDF of a robot's values: the description of a robot whose file is none."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, tostring  # nothing is parsed here

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.pictures import CUT
from arjuna_sim.files.sensor_tag import PluginTag, Tags
from arjuna_sim.model.geometry.shapes import Kind, Part
from arjuna_sim.model.urdf import Joint, Link, Urdf

_SIZES = {
    Kind.BOX: ("size",),
    Kind.CYLINDER: ("radius", "length"),
    Kind.SPHERE: ("radius",),
    Kind.MESH: ("scale",),
}


def urdf_text(urdf: Urdf, tags: Tags) -> str:
    """Return a robot's links, joints, plugins and sensors as a URDF."""
    root = Element("robot", name=urdf.name)
    for link in urdf.links.values():
        _write_link(root, link)
    for joint in urdf.joints.values():
        _write_joint(root, joint)
    for name, mu in tags.friction.items():
        SubElement(SubElement(root, "gazebo", reference=name), "mu1").text = repr(mu)
    for item in tags.items:
        gazebo = SubElement(root, "gazebo", {"reference": item.link} if item.link else {})
        gazebo.append(item.element if isinstance(item, PluginTag) else item.placed())
    return tostring(root, encoding="unicode")


def _write_link(root: Element, link: Link) -> None:
    element = SubElement(root, "link", name=link.name)
    if link.inertial is not None:
        inertial = SubElement(element, "inertial")
        SubElement(inertial, "origin", xyz=_text(link.inertial.center))
        SubElement(inertial, "mass", value=repr(link.inertial.mass))
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = link.inertial.inertia.tolist()
        values = {"ixx": xx, "iyy": yy, "izz": zz, "ixy": xy, "ixz": xz, "iyz": yz}
        SubElement(inertial, "inertia", {key: repr(value) for key, value in values.items()})
    for tag, parts in (("collision", link.collisions), ("visual", link.visuals)):
        for part in parts:
            _write_part(element, tag, part)


def _write_part(link: Element, tag: str, part: Part) -> None:
    """Write a shape; one that URDF has not is left out, and a mesh of several materials is one."""
    shape = part.shape
    path = "" if shape.mesh is None else str(shape.mesh.path).removesuffix(f"{CUT}0")
    if shape.kind not in _SIZES or "#" in path:
        return
    element = SubElement(link, tag)
    _write_origin(element, part.pose)
    keys = _SIZES[shape.kind]
    values = [shape.size] if len(keys) == 1 else [(size,) for size in shape.size]
    sizes = {key: _text(value) for key, value in zip(keys, values, strict=True)}
    if shape.mesh is not None:
        sizes["filename"] = f"file://{path}"
    SubElement(SubElement(element, "geometry"), shape.kind.value, sizes)
    if tag == "visual":
        material = SubElement(element, "material", name=f"{link.get('name')}/{len(link)}")
        SubElement(material, "color", rgba=_text(part.rgba))


def _write_joint(root: Element, joint: Joint) -> None:
    element = SubElement(root, "joint", name=joint.name, type=joint.kind)
    _write_origin(element, joint.T_parent_child)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    if joint.kind == "fixed":
        return
    SubElement(element, "axis", xyz=_text(joint.axis))
    limit = {"velocity": repr(joint.max_speed), "effort": repr(joint.max_effort)}
    if joint.limits is not None:
        limit |= {"lower": repr(joint.limits[0]), "upper": repr(joint.limits[1])}
    SubElement(element, "limit", limit)
    dynamics = {"damping": repr(joint.damping), "friction": repr(joint.friction)}
    SubElement(element, "dynamics", dynamics)
    if joint.mimic is not None:
        mimic = joint.mimic
        factors = {"multiplier": repr(mimic.multiplier), "offset": repr(mimic.offset)}
        SubElement(element, "mimic", {"joint": mimic.joint, **factors})


def _write_origin(element: Element, T: Pose3) -> None:
    SubElement(element, "origin", xyz=_text(T.position), rpy=_text(T.rpy()))


def _text(values: object) -> str:
    return " ".join(repr(float(value)) for value in np.asarray(values).ravel())
