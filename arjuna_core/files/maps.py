"""Maps on disk: map_server's YAML beside a PGM or PNG image."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.errors import MapError, nearest
from arjuna_core.files.atomic import write_together
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

MODES = ("trinary", "scale", "raw")
FORMATS = ("pgm", "png")
_REQUIRED = ("image", "resolution", "origin")
_OPTIONAL = ("negate", "occupied_thresh", "free_thresh", "mode")
_CELLS_MAX = 100_000_000
_UNKNOWN_SHADE = 205.0  # map_saver's; 1 - 205/255 = 0.19608, so the written free_thresh lies below
_UNKNOWN_READS_BACK = 0.196


@dataclass(frozen=True)
class MapOptions:
    """How shades become occupancy, and back.

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


def load_map(path: str | Path) -> OccupancyGrid:
    """Read a map.

    Args:
        path: The YAML file; its `image` is relative to it.

    Returns:
        The grid, row 0 lowest in y.

    Raises:
        MapError: The YAML or the image is missing, broken or has invalid values.
    """
    path = Path(path)
    header = _read_header(path)
    options = _options(path, header)
    shade, alpha = _read_image(path, header)
    frame = GridFrame(
        _positive(path, header, "resolution"), shade.shape[1], shade.shape[0], _origin(path, header)
    )
    return OccupancyGrid(frame, _to_occupancy(shade, alpha, options)[::-1].copy())


def _read_header(path: Path) -> dict[str, Any]:
    header = read_yaml(path, MapError)
    if not isinstance(header, dict):
        raise MapError(path, f"is no map: it must have the keys {', '.join(_REQUIRED)}")
    for key in header:
        if key not in _REQUIRED + _OPTIONAL:
            hint = nearest(str(key), _REQUIRED + _OPTIONAL)
            raise MapError(path, f"unknown key '{key}'; {hint}", str(key))
    for key in _REQUIRED:
        if key not in header:
            raise MapError(path, f"lacks the key '{key}'; required: {', '.join(_REQUIRED)}")
    return header


def _options(path: Path, header: dict[str, Any]) -> MapOptions:
    mode = header.get("mode", "trinary")
    if mode not in MODES:
        raise MapError(path, f"is {mode!r}; valid: {', '.join(MODES)}", "mode")
    negate = header.get("negate", 0)
    if negate not in (0, 1):
        raise MapError(path, f"is {negate!r}; valid: 0, 1", "negate")
    thresholds = [
        _number(path, name, header.get(name, getattr(MapOptions, name)))
        for name in ("occupied_thresh", "free_thresh")
    ]
    if not 0.0 <= thresholds[1] < thresholds[0] <= 1.0:
        problem = "must be 0 <= free_thresh < occupied_thresh <= 1"
        raise MapError(path, problem, "occupied_thresh, free_thresh")
    return MapOptions(mode, bool(negate), *thresholds)


def _number(path: Path, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise MapError(path, f"must be a finite number, got {value!r}", name)
    return float(value)


def _positive(path: Path, header: dict[str, Any], name: str) -> float:
    value = _number(path, name, header[name])
    if value <= 0.0:
        raise MapError(path, f"must be positive, got {value}", name)
    return value


def _origin(path: Path, header: dict[str, Any]) -> SE2:
    value = header["origin"]
    if not isinstance(value, list) or len(value) != 3:
        raise MapError(path, f"must be a list [x, y, yaw], got {value!r}", "origin")
    return SE2(*(_number(path, "origin", entry) for entry in value))


def _read_image(path: Path, header: dict[str, Any]) -> tuple[NDArray[np.float64], Any]:
    name = header["image"]
    if not isinstance(name, str) or not name:
        raise MapError(path, f"must be a file name, got {name!r}", "image")
    image_path = path.parent / name
    try:
        with Image.open(image_path) as image:
            if image.width * image.height > _CELLS_MAX:
                raise MapError(image_path, f"has over {_CELLS_MAX} pixels")
            has_alpha = "A" in image.getbands()
            pixels = np.asarray(image.convert("LA" if has_alpha else "L"), dtype=np.float64)
    except FileNotFoundError as error:
        raise MapError(path, f"image {image_path} does not exist", "image") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise MapError(image_path, f"is no readable PGM or PNG image: {error}") from error
    return (pixels[..., 0], pixels[..., 1]) if has_alpha else (pixels, None)


def _to_occupancy(shade: NDArray[np.float64], alpha: Any, options: MapOptions) -> NDArray[np.int8]:
    """Follow map_server: raw keeps the value, the others compare the darkness with thresholds."""
    if options.mode == "raw":
        return np.where(shade <= OCCUPIED, shade, UNKNOWN).astype(np.int8)
    occupancy = shade / 255.0 if options.negate else 1.0 - shade / 255.0
    between = np.full(shade.shape, float(UNKNOWN))
    if options.mode == "scale":
        span = options.occupied_thresh - options.free_thresh
        between = np.rint((occupancy - options.free_thresh) / span * OCCUPIED)
    occupied, free = occupancy > options.occupied_thresh, occupancy < options.free_thresh
    cells = np.select([occupied, free], [OCCUPIED, FREE], between).astype(np.int8)
    if options.mode == "scale" and alpha is not None:
        cells[alpha < 255] = UNKNOWN
    return cells


def save_map(
    grid: OccupancyGrid,
    stem: str | Path,
    image_format: str = "pgm",
    options: MapOptions = MapOptions(),
) -> tuple[Path, Path]:
    """Write a map atomically as `<stem>.yaml` and `<stem>.<image_format>`.

    Args:
        grid: The map.
        stem: Path without suffix.
        image_format: `pgm` or `png`.
        options: Thresholds and mode to write.

    Returns:
        The YAML's and the image's path.

    Raises:
        MapError: The format or an option is invalid, the map is empty, or it cannot be written.
    """
    stem = Path(stem)
    if image_format not in FORMATS:
        problem = f"image format {image_format!r} is unknown; valid: {', '.join(FORMATS)}"
        raise MapError(stem, problem)
    _check_to_write(stem, grid, options)
    transparent = options.mode == "scale" and bool(grid.unknown().any())
    if transparent and image_format == "pgm":
        raise MapError(stem, "mode 'scale' has no shade for unknown in a pgm image; valid: png")
    written_free_thresh = min(options.free_thresh, _UNKNOWN_READS_BACK)
    image_path = stem.with_name(f"{stem.name}.{image_format}")
    yaml_path = stem.with_name(f"{stem.name}.yaml")
    origin = grid.frame.origin
    header = {
        "image": image_path.name,
        "mode": options.mode,
        "resolution": grid.frame.resolution,
        "origin": [origin.x, origin.y, origin.theta],
        "negate": int(options.negate),
        "occupied_thresh": options.occupied_thresh,
        "free_thresh": written_free_thresh,
    }
    try:
        pixels = _to_shades(grid.data, options, written_free_thresh)
        if transparent:
            pixels = np.dstack((pixels, np.where(grid.unknown(), 0, 255).astype(np.uint8)))
        image = Image.fromarray(pixels[::-1])
        content = io.BytesIO()
        image.save(content, format=_pillow_name(image_format))
        text = yaml.safe_dump(header, sort_keys=False, default_flow_style=None)
        write_together({image_path: content.getvalue(), yaml_path: text.encode()})
    except OSError as error:
        raise MapError(stem, f"cannot be written: {error.strerror}") from error
    return yaml_path, image_path


def _check_to_write(stem: Path, grid: OccupancyGrid, options: MapOptions) -> None:
    """Refuse what could not be read back."""
    if options.mode not in MODES:
        raise MapError(stem, f"mode {options.mode!r} is unknown; valid: {', '.join(MODES)}")
    if not 0.0 <= options.free_thresh < options.occupied_thresh <= 1.0:
        raise MapError(stem, "must be 0 <= free_thresh < occupied_thresh <= 1", "thresholds")
    if not grid.data.size:
        raise MapError(stem, "the map is empty")


def _pillow_name(image_format: str) -> str:
    return "PPM" if image_format == "pgm" else "PNG"


def _to_shades(
    data: NDArray[np.int8], options: MapOptions, written_free_thresh: float
) -> NDArray[np.uint8]:
    """Return the grey levels map_saver writes, top row first in the caller's hands."""
    if options.mode == "raw":
        return np.where(data < 0, 255, data).astype(np.uint8)
    if options.mode == "scale":  # the inverse of what the loader does, so that it reads back
        span = options.occupied_thresh - written_free_thresh
        darkness = written_free_thresh + np.maximum(data, 0) / OCCUPIED * span
        shade = np.rint((1.0 - darkness) * 255.0)
    else:
        occupied = data >= options.occupied_thresh * OCCUPIED
        free = (data >= 0) & (data <= options.free_thresh * OCCUPIED)
        shade = np.select([occupied, free], [0.0, 254.0], _UNKNOWN_SHADE)
    return (255 - shade if options.negate else shade).astype(np.uint8)
