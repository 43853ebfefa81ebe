"""Reading SDF's geometries and materials."""

from __future__ import annotations

from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.material_colours import gazebo_colour
from arjuna_sim.files.meshes.mesh_tag import mesh_shape
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.shapes import GREY, Kind, Shape

_SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "plane": (),
}
_IGNORED = ("polyline", "heightmap", "image", "empty", "ellipsoid", "cone")


def read_shape(xml: XmlFile, geometry: Element, place: str) -> Shape | None:
    """Read a shape; None (and a note) for one that is not simulated.

    Raises:
        WorldError: It is unknown, or its size is no size.
    """
    valid = ", ".join([*_SHAPES, "mesh"])
    if len(geometry) == 0:
        raise xml.fail(place, f"<geometry> is empty; valid: {valid}")
    item = geometry[0]
    if item.tag == "mesh":
        uri = (item.findtext("uri") or "").strip()
        if item.find("submesh") is not None:
            xml.note(f"{place}: mesh '{uri}' is taken whole, not only its <submesh>")
        return mesh_shape(xml, uri, item.findtext("scale") or "1 1 1", place)
    if item.tag in _IGNORED:
        xml.note(
            f"{place}: <{item.tag}> is left out; simulated are {', '.join(_SHAPES)}, mesh",
            NoteKind.UNSUPPORTED,
        )
        return None
    if item.tag not in _SHAPES:
        raise xml.fail(place, f"<{item.tag}> is unknown; valid: {valid}")
    size: tuple[float, ...] = ()
    for key in _SHAPES[item.tag]:
        count = 3 if key == "size" else 1
        text = xml.child(item, key, place).text or ""
        size += xml.sizes(text, count, f"{place} <{key}>")
    if item.tag == "capsule":
        xml.note(f"{place}: the <capsule> is taken to be a cylinder")
        return Shape(Kind.CYLINDER, size)
    return Shape(Kind(item.tag), size)


def read_colour(xml: XmlFile, element: Element, place: str) -> tuple[float, ...]:
    """Return the colour of a `<visual>`'s material.

    Raises:
        WorldError: It is no colour.
    """
    for key in ("diffuse", "ambient"):
        text = element.findtext(f"material/{key}")
        if text:
            words = " ".join([*text.split(), "1"][:4])
            return xml.numbers(words, 4, f"{place} <{key}>")
    return gazebo_colour(element.findtext("material/script/name") or "") or GREY
