"""Cones, prisms and terrain, which files describe by a few numbers or a picture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from mapbox_earcut import triangulate_float64
from PIL import Image

from arjuna_core.arrays import Floats, Ints
from arjuna_core.errors import WorldError
from arjuna_core.files.input_file import open_file

_CORNERS_MAX = 1000
_LEAST = 1e-12  # [m^2]
_OFF = 1e-9  # [share]
_PIXELS_MAX = 4_000_000
_FULL = {"L": 255.0, "I;16": 65535.0, "I": 65535.0}


def cone(radius: float, length: float, corners: int = 48) -> Floats:
    """Return the triangles of an upright cone about the origin, `(N, 3, 3) float64` [m]."""
    angles = np.arange(corners) * 2.0 * math.pi / corners
    low = np.full(corners, -length / 2)
    ring = np.column_stack((radius * np.cos(angles), radius * np.sin(angles), low))
    after = np.roll(ring, -1, axis=0)
    tip, foot = (
        np.tile((0.0, 0.0, length / 2), (corners, 1)),
        np.tile((0.0, 0.0, -length / 2), (corners, 1)),
    )
    return np.concatenate((np.stack((ring, after, tip), 1), np.stack((after, ring, foot), 1)))


def prism(corners: Floats, height: float) -> Floats:
    """Return the triangles of an upright prism that stands on the plane z = 0.

    Args:
        corners: Of its outline, which does not cross itself, `(N, 2) float64` [m].

    Returns:
        `(M, 3, 3) float64` [m], outward.

    Raises:
        ValueError: The outline is none.
    """
    if len(corners) > 1 and np.array_equal(corners[0], corners[-1]):
        corners = corners[:-1]
    if not 3 <= len(corners) <= _CORNERS_MAX:
        raise ValueError(f"has {len(corners)} corners; valid: 3 to {_CORNERS_MAX}")
    if _area(corners) < 0.0:
        corners = corners[::-1]
    caps = _triangles(corners)
    low, high = (np.pad(caps, ((0, 0), (0, 0), (0, 1)), constant_values=z) for z in (0.0, height))
    a = np.pad(corners, ((0, 0), (0, 1)))
    b, up = np.roll(a, -1, axis=0), np.array([0.0, 0.0, height])
    sides = (np.stack((a, b, b + up), 1), np.stack((a, b + up, a + up), 1))
    return np.concatenate((low[:, ::-1], high, *sides))


def _area(corners: Floats) -> float:
    after = np.roll(corners, -1, axis=0)
    return float(np.sum(corners[:, 0] * after[:, 1] - after[:, 0] * corners[:, 1])) / 2.0


def _triangles(corners: Floats) -> Floats:
    """Cut a polygon, counter-clockwise, into triangles, `(N, 3, 2) float64` [m].

    Raises:
        ValueError: It crosses itself or has no area.
    """
    rings = np.array([len(corners)], np.uint32)
    found: Floats = corners[triangulate_float64(corners, rings)].reshape(-1, 3, 2)
    area = _area(corners)
    if area < _LEAST:
        raise ValueError("has no area")
    # Where the outline crosses itself, the triangles cover another area than it encloses.
    if abs(sum(_area(triangle) for triangle in found) - area) > _OFF * area:
        raise ValueError("crosses itself")
    return found


def read_heights(path: Path) -> Floats:
    """Return the heights of a picture, 0 for black to 1 for white.

    A picture of more than 513 pixels along a side is sampled.

    Args:
        path: A PNG, JPEG or TIFF file.

    Returns:
        `(rows, columns) float64`, the first row at the least y, the first column at the least x.

    Raises:
        WorldError: It is no such picture, or is too large.
    """
    try:
        kinds = ("PNG", "JPEG", "TIFF", "BMP")
        with open_file(path, WorldError, 1 << 27) as file, Image.open(file, formats=kinds) as image:
            if image.width * image.height > _PIXELS_MAX or min(image.size) < 2:
                size = f"{image.width} x {image.height}"
                problem = f"is {size}; valid: 2 pixels a side to {_PIXELS_MAX} pixels in all"
                raise WorldError(path, problem)
            grey = image if image.mode in _FULL or image.mode == "F" else image.convert("L")
            pixels = np.asarray(grey, np.float64)
            full = _FULL.get(grey.mode) or max(float(np.abs(pixels).max()), 1e-9)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise WorldError(path, f"is no picture that can be read: {error}") from error
    rows, columns = (_samples(side) for side in pixels.shape)
    heights: Floats = np.clip(pixels[np.ix_(rows, columns)] / full, 0.0, 1.0)[::-1]
    return heights


def _samples(side: int) -> Ints:
    # Beyond 513 samples a side MuJoCo takes seconds to compile a height field.
    chosen: Ints = np.linspace(0, side - 1, min(side, 513)).astype(np.int64)
    return chosen
