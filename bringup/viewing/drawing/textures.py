"""Grids as textured rectangles: cells to a picture by a palette, the picture into glTF."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.exchange.gltf import export_glb

from arjuna_core.grid import OccupancyGrid

MAX_TEXTURE = 4096
"""The edge of a texture that every browser's WebGL takes [pixels]; larger grids are thinned."""


def map_glb(grid: OccupancyGrid, width: float, height: float) -> bytes:
    """Return a map in RViz's colours as a rectangle of a size [m], binary glTF.

    Free is light, occupied black, unknown a greenish grey.
    """
    palette = np.full((256, 3), (128, 144, 140), dtype=np.uint8)
    palette[:101] = np.linspace(250, 0, 101)[:, None]
    image = Image.fromarray(np.ascontiguousarray(thinned(grid.data)[::-1]).view(np.uint8))
    image.putpalette(palette.tobytes())
    return rectangle_glb(image, width, height)


def cost_pixels(grid: OccupancyGrid, opacity: float) -> NDArray[np.uint8]:
    """Return costs in RViz's colours, `(rows, columns, 4) uint8`, the lowest row first.

    Free and unknown are clear; costs go from blue to red, then cyan and magenta. A small grid is
    enlarged: a browser smooths pictures over their pixels, not over their cells.

    Args:
        opacity: Of what is not clear, 0 to 1.
    """
    palette = np.zeros((256, 4), dtype=np.uint8)
    share = np.linspace(0.0, 255.0, 98)
    palette[1:99, 0], palette[1:99, 2] = share, 255 - share
    palette[99, :3] = (0, 255, 255)  # the robot's centre must not be here
    palette[100, :3] = (255, 0, 255)
    palette[1:101, 3] = round(255 * opacity)
    data = thinned(grid.data)
    times = min(max(800 // max(data.shape), 1), 4)
    return palette[np.repeat(np.repeat(data, times, axis=0), times, axis=1).view(np.uint8)]


def thinned(data: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return cells that fit into a texture: of each block the highest, so that no wall is lost."""
    step = -(-max(data.shape) // MAX_TEXTURE)
    if step <= 1:
        return data
    rows, columns = (np.arange(0, size, step) for size in data.shape)
    high: NDArray[np.int8] = np.maximum.reduceat(data, rows, axis=0)
    return np.maximum.reduceat(high, columns, axis=1)


def rectangle_glb(picture: Image.Image, width: float, height: float) -> bytes:
    """Return a rectangle in the ground plane that shows a picture, as binary glTF 2.0.

    Unlike viser's own image it is opaque, so that it is drawn before all that is see-through,
    unlit, and its cells are sharp.

    Args:
        width: Along x, from the origin [m].
        height: Along y, from the origin [m].
    """
    corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], np.float32)
    visuals = trimesh.visual
    material = visuals.material.PBRMaterial(
        baseColorTexture=picture, metallicFactor=0.0, alphaMode="OPAQUE", doubleSided=True
    )
    visual = visuals.TextureVisuals(corners[:, :2] / (width, height), material)
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False)
    return bytes(export_glb(trimesh.Scene([mesh]), tree_postprocessor=_sharpen))


def _sharpen(tree: dict[str, Any]) -> None:
    """Add what trimesh does not write: no light, no blending of cells (glTF 2.0, section 5.26)."""
    tree["extensionsUsed"] = ["KHR_materials_unlit"]
    tree["materials"][0]["extensions"] = {"KHR_materials_unlit": {}}
    nearest, clamp = 9728, 33071
    tree["samplers"] = [
        {"magFilter": nearest, "minFilter": nearest, "wrapS": clamp, "wrapT": clamp}
    ]
    tree["textures"][0]["sampler"] = 0
