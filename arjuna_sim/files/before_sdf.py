"""Files of Gazebo 1.0 to 1.2, before SDF had its name: their tags as those of SDF."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement  # parsing is defusedxml's

ROOT = "gazebo"
"""Their root tag."""

_KEPT = ("name", "type", "id", "version")  # attributes that SDF has as well
_FILES = ("include", "mesh", "image", "heightmap")  # whose `filename` is a `<uri>` now
_OWN = {  # attributes that hold an element's own value
    "origin": "pose",
    "gravity": "xyz",
    "direction": "xyz",
    "parent": "link",
    "child": "link",
    "horizontal_fov": "angle",
    **dict.fromkeys(("ambient", "background", "diffuse", "specular", "emissive"), "rgba"),
    **dict.fromkeys(("shadows", "grid"), "enabled"),
}


def to_sdf(root: Element) -> None:
    """Change a tree's tags, in place: what attributes say, elements say in SDF.

    Source: sdformat's conversion of 1.0 to 1.2 (`sdf/1.2/1_0.convert`).

    Args:
        root: The `<gazebo>` of a file, whose plugins keep their attributes.
    """
    _convert(root)
    root.tag = "sdf"


def _convert(element: Element) -> None:
    if element.tag == "plugin":
        return
    for child in list(element):
        _convert(child)
    own = element.attrib.pop(_OWN.get(element.tag, ""), None)
    if own is not None:
        element.text = own
    for name in [name for name in element.attrib if name not in _KEPT]:
        tag = "uri" if name == "filename" and element.tag in _FILES else name
        SubElement(element, tag).text = element.attrib.pop(name)
    if element.tag == "origin":
        element.tag = "pose"
