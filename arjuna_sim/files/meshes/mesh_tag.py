"""From what a robot or world says of a mesh to the shape."""

from __future__ import annotations

from pathlib import Path

from arjuna_sim.files.meshes.triangles import MESH_SUFFIXES, MeshError, read_mesh
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.convex_pieces import surface
from arjuna_sim.model.geometry.shapes import Kind, Mesh, Shape
from arjuna_sim.model.notes import NoteKind

_REACH_MAX = 1e5  # [m]
_SURFACE_MIN = 1e-9  # [m^2]


def mesh_shape(
    xml: XmlFile, uri: str, scale: str, place: str, part: str = "", centred: bool = False
) -> Shape | None:
    """Read a mesh; None (and a note) where it is missing, of a foreign form, or broken and drawn.

    Args:
        xml: The file that refers to it.
        uri: Path or URI of the mesh.
        scale: Three numbers.
        place: Position in the file; of a visual it ends in `visual`.
        part: Name of the part of it that is meant; "" for all of it.
        centred: Whether that part is put about its own middle.

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
        mesh = _read(xml, path, part, centred, f"{place}: mesh '{uri}'")
    except MeshError as error:
        if not place.endswith("visual"):
            raise xml.fail(place, f"mesh '{uri}' {error.problem}") from error
        xml.note(f"{place}: mesh '{uri}' {error.problem}, so it is not drawn")
        return None
    reach = mesh.reach * max(map(abs, size))
    if not reach <= _REACH_MAX:
        raise xml.fail(place, f"mesh '{uri}' is {reach:.3g} m large; valid: up to {_REACH_MAX:g}")
    if not surface(mesh.triangles * size) > _SURFACE_MIN:
        xml.note(f"{place}: mesh '{uri}' has no surface, so it is left out", NoteKind.BROKEN)
        return None
    return Shape(Kind.MESH, size, mesh)


def _read(xml: XmlFile, path: Path, part: str, centred: bool, place: str) -> Mesh:
    """Return a mesh or a part of it, each read once.

    Raises:
        MeshError: It is broken.
    """
    key = path.with_name(f"{path.name}#{part}{'~' * centred}") if part else path
    if key in xml.meshes:
        return xml.meshes[key]
    triangles = read_mesh(path, part)
    if part and not len(triangles):
        xml.note(f"{place} has no part '{part}': all of it is taken")
        triangles = read_mesh(path)
    if centred:
        points = triangles.reshape(-1, 3)
        triangles = triangles - (points.min(axis=0) + points.max(axis=0)) / 2
    resolved = path.resolve()
    xml.meshes[key] = Mesh(resolved.with_name(key.name) if part else resolved, triangles)
    return xml.meshes[key]
