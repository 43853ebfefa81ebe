"""The robot as /robot_description has it, one binary glTF a link, and where its meshes are."""

from __future__ import annotations

import io
import math
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import trimesh
import yourdfpy
from collada.common import DaeError
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, fromstring
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError, InputFileError, shortened
from arjuna_core.files.input_file import MESH_BYTES_MAX, open_file

Finder = Callable[[str], Path | None]
"""Returns the file that a mesh's URI names, or None."""
_UNREADABLE = (ParseError, DefusedXmlException, ValueError, yourdfpy.urdf.URDFError)
_BROKEN = (
    *(OSError, ValueError, TypeError, LookupError, AttributeError, SyntaxError, OverflowError),
    *(ArjunaError, DaeError, struct.error, RuntimeError),
)
_GREY = (0.6, 0.6, 0.65, 1.0)
_MOVING = ("revolute", "continuous", "prismatic")


class _Beside(trimesh.resolvers.FilePathResolver):
    """Finds the materials and textures of a mesh, those that the one door opens."""

    def absolute(self, name: str) -> Path:
        path = super().absolute(name)
        try:
            if path.exists():
                open_file(path, largest=MESH_BYTES_MAX).close()
        except InputFileError as error:
            raise ValueError(str(error)) from error
        return path


def find_mesh(uri: str) -> Path | None:
    """Return the file of a mesh in the environment's packages or below this folder, or None."""
    from arjuna_sim.files.search_path import EscapeError, SearchPath

    try:
        return SearchPath.of().find(Path.cwd() / "robot.urdf", uri)
    except EscapeError:
        return None


class VisualError(ArjunaError):
    """A robot's description cannot be drawn."""


@dataclass(frozen=True)
class VisualModel:
    """A robot to be drawn.

    Attributes:
        root: The link above all others.
        glbs: Each visible link in its own frame, as binary glTF.
        notes: On what is not drawn.
        joints: Limits [rad or m] of the joints that move by themselves, +-pi where they have none.
    """

    root: str
    glbs: dict[str, bytes]
    notes: tuple[str, ...]
    name: str = ""
    joints: dict[str, tuple[float, float]] = field(default_factory=dict)


def read(description: str, find: Finder = find_mesh, longest: int = 10_000_000) -> VisualModel:
    """Return the robot of the text of a URDF, or of an SDF model.

    Raises:
        VisualError: The text is none, or has no root.
    """
    robot = _parse(description, longest)
    colours = {m.name: m.color.rgba for m in robot.materials if m.color is not None}
    glbs: dict[str, bytes] = {}
    notes: list[str] = []
    for link in robot.links:
        meshes = []
        for visual in link.visuals:
            with _noting(notes, link.name):
                meshes += _meshes(visual, colours, find)
        if meshes:
            with _noting(notes, link.name):
                glbs[link.name] = bytes(trimesh.Scene(meshes).export(file_type="glb"))
    return VisualModel(_root(robot), glbs, tuple(notes), str(robot.name), _joints(robot))


def _joints(robot: Any) -> dict[str, tuple[float, float]]:
    own = (j for j in robot.joints if j.type in _MOVING and j.mimic is None)
    return {
        joint.name: (-math.pi, math.pi)
        if joint.type == "continuous" or joint.limit is None
        else (float(joint.limit.lower or 0.0), float(joint.limit.upper or 0.0))
        for joint in own
    }


def mesh_glb(uri: str, find: Finder = find_mesh) -> bytes:
    """Return the mesh that a URI names as binary glTF.

    Raises:
        VisualError: It is not found or cannot be read.
    """
    notes: list[str] = []
    with _noting(notes, "mesh"):
        meshes = _loaded(SimpleNamespace(filename=uri, scale=None), find)
        return bytes(trimesh.Scene(meshes).export(file_type="glb"))
    raise VisualError(notes[0])


@contextmanager
def _noting(notes: list[str], name: str) -> Iterator[None]:
    try:
        yield
    except _BROKEN as error:
        notes.append(f"{name}: {shortened(' '.join(str(error).split()), 300)}")


def _root(robot: Any) -> str:
    children = {joint.child for joint in robot.joints}
    roots = [link.name for link in robot.links if link.name not in children]
    if not roots:
        raise VisualError("the robot's description has no root link")
    return str(roots[0])


def _parse(description: str, longest: int) -> Any:
    """Return yourdfpy's robot, after a parser that refuses entities and the network."""
    from arjuna_sim.inputs import as_urdf

    if len(description) > longest:
        raise VisualError(f"a description of {len(description)} bytes; valid: up to {longest}")
    try:
        text = as_urdf(description).encode()
        fromstring(text)
        urdf = yourdfpy.URDF.load(io.BytesIO(text), build_scene_graph=False, load_meshes=False)
    except (*_UNREADABLE, ArjunaError) as error:
        raise VisualError(f"the robot's description is no URDF: {error}") from error
    return urdf.robot


def _meshes(visual: Any, colours: dict[str, Any], find: Finder) -> list[trimesh.Trimesh]:
    geometry, material = visual.geometry, visual.material
    colour = None if material is None else colours.get(material.name)
    if material is not None and material.color is not None:
        colour = material.color.rgba
    if geometry.mesh is not None:
        meshes = _loaded(geometry.mesh, find)
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
        return trimesh.creation.cylinder(shape.radius, shape.length, sections=24)
    if geometry.sphere is not None:
        return trimesh.creation.icosphere(subdivisions=2, radius=geometry.sphere.radius)
    raise ValueError("its geometry is no box, cylinder, sphere or mesh")


def _loaded(shape: Any, find: Finder) -> list[trimesh.Trimesh]:
    path = find(shape.filename)
    if path is None:
        raise ValueError(f"'{shape.filename}' is not found; --package-path adds folders")
    with open_file(path, largest=MESH_BYTES_MAX) as file:
        kind, beside = path.suffix[1:].lower(), _Beside(str(path))
        scene = trimesh.load_scene(file, file_type=kind, resolver=beside)
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
