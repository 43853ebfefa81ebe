"""The robot's looks: of /robot_description's text, one binary glTF a link."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yourdfpy
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, fromstring
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError

FindMesh = Callable[[str], Path | None]
"""Returns the file that a mesh's URI names, or None."""
_MAX_TEXT = 10_000_000
_GREY = (0.6, 0.6, 0.65, 1.0)
_SIDES = 24


class LooksError(ArjunaError):
    """A robot's description cannot be drawn."""


@dataclass(frozen=True)
class Looks:
    """What a robot looks like.

    Attributes:
        root: The link that all others hang on.
        glbs: What each link that can be seen looks like in its own frame, as binary glTF.
        notes: On what is not drawn.
    """

    root: str
    glbs: dict[str, bytes]
    notes: tuple[str, ...]


def read(description: str, find_mesh: FindMesh) -> Looks:
    """Return a robot's looks.

    Args:
        description: The URDF's text.
        find_mesh: Finds the meshes.

    Raises:
        LooksError: The text is no URDF, or has no root.
    """
    robot = _parse(description)
    colours = {m.name: m.color.rgba for m in robot.materials if m.color is not None}
    glbs: dict[str, bytes] = {}
    notes: list[str] = []
    for link in robot.links:
        meshes = []
        for visual in link.visuals:
            try:
                meshes += _meshes(visual, colours, find_mesh)
            except (OSError, ValueError, TypeError, LookupError, AttributeError) as error:
                notes.append(f"{link.name}: {error}")
        if meshes:
            glbs[link.name] = bytes(trimesh.Scene(meshes).export(file_type="glb"))
    return Looks(_root(robot), glbs, tuple(notes))


def _root(robot: Any) -> str:
    children = {joint.child for joint in robot.joints}
    roots = [link.name for link in robot.links if link.name not in children]
    if not roots:
        raise LooksError("the robot's description has no root link")
    return str(roots[0])


def _parse(description: str) -> Any:
    """Return yourdfpy's robot, after a parser that refuses entities and the network."""
    text = description.encode()
    if len(text) > _MAX_TEXT:
        raise LooksError(f"a description of {len(text)} bytes; valid: up to {_MAX_TEXT}")
    try:
        fromstring(text)
        urdf = yourdfpy.URDF.load(io.BytesIO(text), build_scene_graph=False, load_meshes=False)
    except (ParseError, DefusedXmlException, ValueError, yourdfpy.urdf.URDFError) as error:
        raise LooksError(f"the robot's description is no URDF: {error}") from error
    return urdf.robot


def _meshes(visual: Any, colours: dict[str, Any], find_mesh: FindMesh) -> list[trimesh.Trimesh]:
    """Return what a visual element draws, in its link's frame."""
    geometry, material = visual.geometry, visual.material
    colour = None if material is None else colours.get(material.name)
    if material is not None and material.color is not None:
        colour = material.color.rgba
    if geometry.mesh is not None:
        meshes = _loaded(geometry.mesh, find_mesh)
    else:
        meshes = [_primitive(geometry)]
        colour = _GREY if colour is None else colour
    for mesh in meshes:
        if colour is not None:
            mesh.visual = trimesh.visual.TextureVisuals(material=_paint(colour))
        if visual.origin is not None:
            mesh.apply_transform(visual.origin)
    return meshes


def _primitive(geometry: Any) -> Any:
    if geometry.box is not None:
        return trimesh.creation.box(extents=geometry.box.size)
    if geometry.cylinder is not None:
        shape = geometry.cylinder
        return trimesh.creation.cylinder(shape.radius, shape.length, sections=_SIDES)
    if geometry.sphere is not None:
        return trimesh.creation.icosphere(subdivisions=2, radius=geometry.sphere.radius)
    raise ValueError("its geometry is no box, cylinder, sphere or mesh")


def _loaded(shape: Any, find_mesh: FindMesh) -> list[trimesh.Trimesh]:
    """Return a mesh file's parts, scaled."""
    path = find_mesh(shape.filename)
    if path is None:
        raise ValueError(f"'{shape.filename}' is not found; --package-path adds folders")
    scene = trimesh.load_scene(str(path))
    meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    if not meshes:
        raise ValueError(f"'{shape.filename}' holds no triangles")
    scale = 1.0 if shape.scale is None else shape.scale
    for mesh in meshes:
        mesh.apply_scale(scale)
    return meshes


def _paint(rgba: Any) -> trimesh.visual.material.PBRMaterial:
    factors: NDArray[np.float64] = np.asarray(rgba, dtype=np.float64)
    return trimesh.visual.material.PBRMaterial(
        baseColorFactor=factors,
        metallicFactor=0.0,
        roughnessFactor=0.8,
        alphaMode="BLEND" if factors[3] < 1.0 else "OPAQUE",
    )
