"""Reading the pictures of heightmaps: black is low, white is high."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.errors import WorldError

_PIXELS_MAX = 4_000_000
_SIDE_MAX = 513  # beyond it MuJoCo takes seconds; a coarser grid stands for the picture
_FULL = {"L": 255.0, "I;16": 65535.0, "I": 65535.0}


def read_heights(path: Path) -> NDArray[np.float64]:
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
        with Image.open(path, formats=("PNG", "JPEG", "TIFF", "BMP")) as image:
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
    heights: NDArray[np.float64] = np.clip(pixels[np.ix_(rows, columns)] / full, 0.0, 1.0)[::-1]
    return heights


def _samples(side: int) -> NDArray[np.int64]:
    chosen: NDArray[np.int64] = np.linspace(0, side - 1, min(side, _SIDE_MAX)).astype(np.int64)
    return chosen
