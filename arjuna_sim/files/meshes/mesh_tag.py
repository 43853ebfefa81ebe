"""From what a robot or world says of a mesh to the shape."""

from __future__ import annotations

import numpy as np

from arjuna_sim.files.meshes.triangles import MESH_SUFFIXES, MeshError, read_mesh
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.shapes import Kind, Mesh, Shape

_REACH_MAX = 1e5  # [m]


def mesh_shape(xml: XmlFile, uri: str, scale: str, place: str) -> Shape | None:
    """Read a mesh; None (and a note) where it is missing, of a foreign form, or broken and drawn.

    Args:
        xml: The file that refers to it.
        uri: Path or URI of the mesh.
        scale: Three numbers.
        place: Where it is referred to; what is only drawn ends in `visual`.

    Raises:
        InputFileError: A mesh that collides is broken, or the scale is no scale.
    """
    size = xml.numbers(scale, 3, f"{place} scale")
    if 0.0 in size:
        raise xml.fail(f"{place} scale", f"{scale!r} must not be zero")
    path = xml.find(uri, place)
    if path is None:
        xml.note(f"{place}: mesh '{uri}' does not exist, so it is left out", NoteKind.MISSING)
        return None
    if path.suffix.lower() not in MESH_SUFFIXES:
        xml.note(
            f"{place}: mesh '{uri}' left out; simulated are {', '.join(MESH_SUFFIXES)}",
            NoteKind.UNSUPPORTED,
        )
        return None
    try:
        if path not in xml.meshes:
            xml.meshes[path] = Mesh(path.resolve(), read_mesh(path))
    except MeshError as error:
        if not place.endswith("visual"):
            raise xml.fail(place, f"mesh '{uri}' {error.problem}") from error
        xml.note(f"{place}: mesh '{uri}' {error.problem}, so it is not drawn")
        return None
    reach = float(np.abs(xml.meshes[path].triangles).max()) * max(map(abs, size))
    if not reach <= _REACH_MAX:
        raise xml.fail(place, f"mesh '{uri}' is {reach:.3g} m large; valid: up to {_REACH_MAX:g}")
    return Shape(Kind.MESH, size, xml.meshes[path])
