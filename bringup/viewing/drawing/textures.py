"""Grids as textured rectangles: cells to a PNG by a palette, the PNG into a binary glTF."""

from __future__ import annotations

import io
import json
import struct

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.grid import OccupancyGrid

MAX_TEXTURE = 4096
"""The edge of a texture that every browser's WebGL takes [pixels]; larger grids are thinned."""

# glTF 2.0, sections 4.4 and 5, after OpenGL
_GLB, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942
_NEAREST, _CLAMP = 9728, 33071
_FLOAT, _SHORT, _TRIANGLES = 5126, 5123, 4


def map_glb(grid: OccupancyGrid, width: float, height: float) -> bytes:
    """Return a map in RViz's colours as a rectangle of a size [m], binary glTF.

    Free is light, occupied black, unknown a greenish grey.
    """
    palette = np.full((256, 3), (128, 144, 140), dtype=np.uint8)
    palette[:101] = np.linspace(250, 0, 101)[:, None]
    image = Image.fromarray(np.ascontiguousarray(thinned(grid.data)[::-1]).view(np.uint8))
    image.putpalette(palette.tobytes())
    out = io.BytesIO()
    image.save(out, "png", compress_level=3)
    return rectangle_glb(out.getvalue(), width, height)


def cost_pixels(grid: OccupancyGrid, opacity: float) -> NDArray[np.uint8]:
    """Return costs in RViz's colours, `(rows, columns, 4) uint8`, the lowest row first.

    Free and unknown are clear; costs go from blue to red, then cyan and magenta. A small grid is
    enlarged: a browser smooths pictures over their pixels, not over their cells.

    Args:
        grid: The costs.
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


def rectangle_glb(png: bytes, width: float, height: float) -> bytes:
    """Return a rectangle in the ground plane that shows a picture, as binary glTF 2.0.

    Unlike viser's own image it is opaque, so that it is drawn before all that is see-through,
    unlit, and its cells are sharp.

    Args:
        width: Along x, from the origin [m].
        height: Along y, from the origin [m].
    """
    corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], np.float32)
    texture = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
    faces = np.array([0, 1, 2, 0, 2, 3], np.uint16)
    parts = [corners.tobytes(), texture.tobytes(), faces.tobytes(), png]
    views, start = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": start, "byteLength": len(part)})
        start += len(part)
    binary = b"".join(parts)
    binary += b"\0" * (-len(binary) % 4)
    head = _document(views, len(binary), [float(width), float(height), 0.0])
    text = json.dumps(head, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text
    chunks += struct.pack("<II", len(binary), _BIN) + binary
    return struct.pack("<III", _GLB, 2, 12 + len(chunks)) + chunks


def _document(views: list[dict[str, int]], length: int, far: list[float]) -> dict[str, object]:
    """Return the JSON of a rectangle's glTF, whose far corner is at `far` [m]."""
    material = {
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0},
        "extensions": {"KHR_materials_unlit": {}},
        "alphaMode": "OPAQUE",
        "doubleSided": True,
    }
    vertices = {"componentType": _FLOAT, "count": 4}
    primitive = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "indices": 2,
        "material": 0,
        "mode": _TRIANGLES,
    }
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [
            {"magFilter": _NEAREST, "minFilter": _NEAREST, "wrapS": _CLAMP, "wrapT": _CLAMP}
        ],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": [
            {**vertices, "bufferView": 0, "type": "VEC3", "min": [0.0, 0.0, 0.0], "max": far},
            {**vertices, "bufferView": 1, "type": "VEC2"},
            {"bufferView": 2, "componentType": _SHORT, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": length}],
    }
