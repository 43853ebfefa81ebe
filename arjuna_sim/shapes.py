"""Bodies' shapes, as URDF and SDF have them, and their MuJoCo geoms."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import mujoco

from arjuna_sim.pose3 import ORIGIN, Pose3

MESH_SUFFIXES = (".obj", ".stl")
GREY = (0.7, 0.7, 0.7, 1.0)


class Kind(Enum):
    """What a shape is."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    PLANE = "plane"
    MESH = "mesh"


class Group(Enum):
    """MuJoCo geom groups: what rays hit and what is drawn is chosen by group."""

    WORLD_COLLISION = 0
    WORLD_VISUAL = 1
    ROBOT_VISUAL = 2
    ROBOT_COLLISION = 3


@dataclass(frozen=True)
class Shape:
    """A shape in its own frame.

    Attributes:
        kind: What it is.
        size: Box: edges (x, y, z). Cylinder: radius, length. Sphere: radius. Plane: nothing.
            Mesh: scale (x, y, z). All [m].
        mesh: The file of a mesh.
    """

    kind: Kind
    size: tuple[float, ...] = ()
    mesh: Path | None = None


@dataclass(frozen=True)
class Part:
    """A shape at a place.

    Attributes:
        shape: The shape.
        pose: Its pose in its link or world.
        rgba: Its colour, 0..1.
    """

    shape: Shape
    pose: Pose3 = ORIGIN
    rgba: tuple[float, ...] = GREY


def add_geom(spec: Any, body: Any, part: Part, group: Group, name: str = "") -> Any:
    """Add a part to a MuJoCo body.

    Args:
        spec: The `mujoco.MjSpec`.
        body: The spec's body.
        part: What to add.
        group: Says whether it collides: visual groups do not.
        name: The geom's name.

    Returns:
        The spec's geom, massless.
    """
    shape = part.shape
    geom = body.add_geom(pos=part.pose.position, quat=part.pose.quaternion, rgba=part.rgba)
    geom.name, geom.group, geom.mass = name, group.value, 0.0
    # Robot against world only: neither collides with itself.
    geom.contype = int(group is Group.WORLD_COLLISION)
    geom.conaffinity = int(group is Group.ROBOT_COLLISION)
    geom.type = getattr(mujoco.mjtGeom, f"mjGEOM_{shape.kind.name}")
    if shape.kind is Kind.BOX:
        geom.size = [edge / 2 for edge in shape.size]
    elif shape.kind is Kind.CYLINDER:
        geom.size = [shape.size[0], shape.size[1] / 2, 0.0]
    elif shape.kind is Kind.SPHERE:
        geom.size = [shape.size[0], 0.0, 0.0]
    elif shape.kind is Kind.PLANE:
        geom.size = [0.0, 0.0, 1.0]
    else:
        geom.meshname = _mesh(spec, shape)
    return geom


def _mesh(spec: Any, shape: Shape) -> str:
    """Register a mesh once for a file and scale."""
    name = f"{shape.mesh}@{shape.size}"
    if all(mesh.name != name for mesh in spec.meshes):
        spec.add_mesh(name=name, file=str(shape.mesh), scale=shape.size)
    return name
