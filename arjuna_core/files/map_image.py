"""The images of maps: shades that stand for occupancy, as map_server reads and writes them."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.arrays import Bytes
from arjuna_core.errors import MapError
from arjuna_core.files.input_file import open_file
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN

MODES = ("trinary", "scale", "raw")
_KINDS = ("PPM", "PNG", "BMP", "JPEG", "TIFF", "GIF", "WEBP")  # none that runs another program
_CELLS_MAX = 100_000_000  # 500 m x 500 m at 5 cm: more is a mistake or an attack


@dataclass(frozen=True)
class MapOptions:
    """Thresholds by which shades become occupancy, and back.

    Attributes:
        mode: `trinary`, `scale` or `raw`.
        negate: Whether white is occupied.
        occupied_thresh: Occupancy (0..1) above which a cell is occupied.
        free_thresh: Occupancy (0..1) below which a cell is free.
    """

    mode: str = "trinary"
    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.25

    @property
    def written_free_thresh(self) -> float:
        """The free_thresh to write, so that unknown cells read back as such."""
        # Shade 205 reads back as 1 - 205/255 = 0.19608: the threshold is below it.
        return min(self.free_thresh, 0.196)


MAP_SAVER = MapOptions()


class Pixels(NamedTuple):
    """An image's pixels, top row first.

    Attributes:
        values: `(height, width)`, 0 for black.
        white: The value of white.
        alpha: `(height, width) uint8`, None where the image has none.
    """

    values: NDArray[np.unsignedinteger[Any]]
    white: int
    alpha: Any


def read_image(path: Path) -> Pixels:
    """Return the pixels of an image.

    Raises:
        MapError: It is missing, no image, or too large.
    """
    try:
        with open_file(path, MapError, 1 << 29) as file, Image.open(file, formats=_KINDS) as image:
            if image.width * image.height > _CELLS_MAX:
                raise MapError(path, f"has over {_CELLS_MAX} pixels")
            return _pixels(image)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise MapError(path, f"is no readable PGM or PNG image: {error}") from error


def _pixels(image: Image.Image) -> Pixels:
    """Return an image's greys of 8 or 16 bits, or the sums of its red, green and blue."""
    has_alpha = "A" in image.getbands() or "transparency" in image.info
    if image.mode.startswith("I"):
        return Pixels(np.clip(np.asarray(image), 0, 65535).astype(np.uint16), 65535, None)
    if image.mode in ("1", "L", "F") and not has_alpha:
        return Pixels(np.asarray(image.convert("L")), 255, None)
    colours = np.asarray(image.convert("RGBA" if has_alpha else "RGB"))
    alpha = colours[..., 3] if has_alpha else None
    return Pixels(colours[..., :3].sum(axis=-1, dtype=np.uint16), 765, alpha)


def occupancy_of(pixels: Pixels, options: MapOptions) -> NDArray[np.int8]:
    """Return the occupancy that pixels stand for, `(height, width) int8`.

    Source: map_server: raw keeps the value of 0 to 255, the others compare the darkness with
        thresholds; red, green and blue are averaged, and trinary takes alpha for a fourth colour.
    """
    values, white, alpha = pixels
    if options.mode == "trinary" and alpha is not None:
        shade = values.astype(np.float64) * (255.0 / white)
        return _occupancy_by_shade((3.0 * shade + alpha) / 4.0, options)
    cells: NDArray[np.int8] = _occupancy_by_shade(np.arange(white + 1) * (255.0 / white), options)[
        values
    ]
    if options.mode == "scale" and alpha is not None:
        cells[alpha < 255] = UNKNOWN
    return cells


def _occupancy_by_shade(shade: NDArray[np.floating[Any]], options: MapOptions) -> NDArray[np.int8]:
    if options.mode == "raw":
        rounded = np.floor(shade + 0.5)
        return np.where(rounded <= OCCUPIED, rounded, UNKNOWN).astype(np.int8)
    occupancy = shade / 255.0 if options.negate else 1.0 - shade / 255.0
    between = np.full(shade.shape, float(UNKNOWN))
    if options.mode == "scale":
        span = (options.occupied_thresh - options.free_thresh) or 1.0
        between = np.rint((occupancy - options.free_thresh) / span * OCCUPIED)
    occupied, free = occupancy > options.occupied_thresh, occupancy < options.free_thresh
    return np.select([occupied, free], [OCCUPIED, FREE], between).astype(np.int8)


def encoded(data: NDArray[np.int8], options: MapOptions, image_format: str) -> bytes:
    """Return the pgm, png or bmp file of occupancy `(height, width) int8`, row 0 lowest in y."""
    pixels = _shades(data, options)
    if options.mode == "scale" and (data < 0).any():
        pixels = np.dstack((pixels, np.where(data < 0, 0, 255).astype(np.uint8)))
    content = io.BytesIO()
    Image.fromarray(pixels[::-1]).save(content, {"pgm": "PPM"}.get(image_format, image_format))
    return content.getvalue()


def _shades(data: NDArray[np.int8], options: MapOptions) -> Bytes:
    if options.mode == "raw":
        return np.where(data < 0, 255, data).astype(np.uint8)
    if options.mode == "scale":  # the inverse of what the loader does, so that it reads back
        low = options.written_free_thresh
        span = options.occupied_thresh - low
        darkness = low + np.maximum(data, 0) / OCCUPIED * span
        shade = np.rint((1.0 - darkness) * 255.0)
    else:
        occupied = data >= options.occupied_thresh * OCCUPIED
        free = (data >= 0) & (data <= options.free_thresh * OCCUPIED)
        # map_saver's shade 205 for unknown.
        shade = np.select([occupied, free], [0.0, 254.0], 205.0)
    return (255 - shade if options.negate else shade).astype(np.uint8)
