"""Bodies of one shape: their drawings from rows, and the triangles of each shape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bringup.viewing.drawing.values import Drawing, Solids


def solids(shape: str, rows: Sequence[tuple[Any, ...]], **where: Any) -> Drawing:
    """Return bodies of a shape.

    Args:
        rows: Position, quaternion, size, colour and opacity of each.
        where: Frame and stamp.
    """
    positions, wxyzs, sizes, colours, opacities = zip(*rows, strict=True) if rows else 5 * ((),)
    return Solids(
        shape=shape,
        positions=np.array(positions, np.float32).reshape(-1, 3),
        wxyzs=np.array(wxyzs, np.float32).reshape(-1, 4),
        sizes=np.array(sizes, np.float32).reshape(-1, 3),
        colours=np.array(colours, np.uint8).reshape(-1, 3),
        opacities=np.array(opacities, np.float32),
        **where,
    )


def arrow_pose(tail: NDArray[Any], tip: NDArray[Any]) -> Any:
    """Return middle, quaternion and length of an arrow; None where its ends are one point."""
    along = tip - tail
    length = float(np.linalg.norm(along))
    if length < 1e-6:
        return None
    x, y, z = along / length
    # the shortest turn from the x axis to the arrow
    w = math.sqrt(max((1.0 + x) / 2.0, 0.0))
    turn = (w, 0.0, -z / (2.0 * w), y / (2.0 * w)) if w > 1e-6 else (0.0, 0.0, 0.0, 1.0)
    return tuple((tail + tip) / 2.0), turn, length


@cache
def triangles(shape: str) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Return a shape's vertices `(V, 3)` [m] in a box with edges of 1 m, and faces `(F, 3)`."""
    import trimesh

    make = trimesh.creation
    to_x = trimesh.transformations.rotation_matrix(math.pi / 2.0, (0.0, 1.0, 0.0))
    if shape == "box":
        mesh = make.box((1.0, 1.0, 1.0))
    elif shape == "sphere":
        mesh = make.icosphere(subdivisions=1, radius=0.5)
    elif shape == "cylinder":
        mesh = make.cylinder(0.5, 1.0, sections=10)
    elif shape == "cone":
        mesh = make.cone(0.5, 1.0, sections=12)
        mesh.apply_translation((0.0, 0.0, -0.5))
        mesh.apply_transform(to_x)
    else:
        shaft, head = make.cylinder(0.25, 0.77, sections=8), make.cone(0.5, 0.23, sections=12)
        shaft.apply_translation((0.0, 0.0, -0.115))
        head.apply_translation((0.0, 0.0, 0.27))
        mesh = trimesh.util.concatenate([shaft, head])
        mesh.apply_transform(to_x)
    # a vertex for each corner of each face, so that edges are sharp
    vertices = np.asarray(mesh.vertices, np.float32)[np.asarray(mesh.faces).reshape(-1)]
    if shape == "sphere":
        return np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)
    return vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
