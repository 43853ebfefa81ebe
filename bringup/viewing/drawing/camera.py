"""A camera's image message as pixels for the panel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core import pixels as images

WIDTH = 320
"""What the panel shows at most [pixels]."""


def pixels(encoding: str, height: int, width: int, step: int, data: bytes) -> NDArray[np.uint8]:
    """Return an image as `(rows, columns, 3) uint8`, thinned to at most `WIDTH` columns.

    Raises:
        ValueError: The encoding is not known, or the data is too short.
    """
    return images.pixels(encoding, height, width, step, data, WIDTH)
