"""Maps on disk: map_server's YAML beside a PGM or PNG image."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

import yaml

from arjuna_core.errors import MapError, closest
from arjuna_core.files.input_file import head_of
from arjuna_core.files.map_image import (
    MAP_SAVER,
    MODES,
    MapOptions,
    encoded,
    occupancy_of,
    read_image,
)
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

FORMATS = ("pgm", "png", "bmp")
_REQUIRED = ("image", "resolution", "origin")
_OPTIONAL = ("negate", "occupied_thresh", "free_thresh", "mode")


def load_map(
    path: str | Path, warn: Callable[[str], None] = lambda sentence: None
) -> OccupancyGrid:
    """Read a map.

    Args:
        path: The YAML file; its `image` is relative to it.
        warn: Takes a sentence for each key that is unknown, which is passed over.

    Returns:
        The grid, row 0 lowest in y.

    Raises:
        MapError: The YAML or the image is missing, broken or has invalid values.
    """
    path = Path(path)
    header = _read_header(path, warn)
    options = _options(path, header)
    if not isinstance(header["image"], str) or not header["image"]:
        raise MapError(path, f"must be a file name, got {header['image']!r}", "image")
    image = path.parent / header["image"]
    if not os.path.exists(image):  # noqa: PTH110 - Path.exists raises where a name is too long
        beside = path.parent / PureWindowsPath(image).name  # written on another machine
        hint = f"; beside the YAML lies '{beside.name}'" if os.path.exists(beside) else ""  # noqa: PTH110
        raise MapError(path, f"image {image} does not exist{hint}", "image")
    pixels = read_image(image)
    resolution = _number(path, "resolution", header["resolution"])
    if resolution <= 0.0:
        raise MapError(path, f"must be positive, got {resolution}", "resolution")
    height, width = pixels.values.shape
    frame = GridFrame(resolution, width, height, _origin(path, header))
    return OccupancyGrid(frame, occupancy_of(pixels, options)[::-1].copy())


def _read_header(path: Path, warn: Callable[[str], None]) -> dict[str, Any]:
    header = read_yaml(path, MapError)
    if not isinstance(header, dict):
        raise MapError(path, f"is no map: it must have the keys {', '.join(_REQUIRED)}")
    for key in header:
        if key not in _REQUIRED + _OPTIONAL:
            warn(f"{path}: unknown key '{key}'{closest(str(key), _REQUIRED + _OPTIONAL)}")
    for key in _REQUIRED:
        if key not in header:
            raise MapError(path, f"lacks the key '{key}'; required: {', '.join(_REQUIRED)}")
    return header


def _options(path: Path, header: dict[str, Any]) -> MapOptions:
    mode = str(header.get("mode", "trinary")).lower()
    if mode not in MODES:
        raise MapError(path, f"is '{mode}'; valid: {', '.join(MODES)}", "mode")
    negate = header.get("negate", 0)
    if negate not in (0, 1):
        raise MapError(path, f"is {negate!r}; valid: 0, 1", "negate")
    thresholds = [
        _number(path, name, header.get(name, getattr(MapOptions, name)))
        for name in ("occupied_thresh", "free_thresh")
    ]
    if not 0.0 <= thresholds[1] <= thresholds[0] <= 1.0:
        problem = "must be 0 <= free_thresh <= occupied_thresh <= 1"
        raise MapError(path, problem, "occupied_thresh, free_thresh")
    return MapOptions(mode, bool(negate), *thresholds)


def _number(path: Path, name: str, value: Any) -> float:
    """Return a number of the header, in quotes or not, as yaml-cpp reads them."""
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise MapError(path, f"must be a finite number, got {value!r}", name)
    return number


def _origin(path: Path, header: dict[str, Any]) -> SE2:
    value = header["origin"]
    if not isinstance(value, list) or len(value) != 3:
        raise MapError(path, f"must be a list [x, y, yaw], got {value!r}", "origin")
    return SE2(*(_number(path, "origin", entry) for entry in value))


def save_map(
    grid: OccupancyGrid,
    stem: str | Path,
    image_format: str = "pgm",
    options: MapOptions = MAP_SAVER,
) -> tuple[Path, Path]:
    """Write a map atomically as `<stem>.yaml` and `<stem>.<image_format>`, over a map's alone.

    Returns:
        The YAML's and the image's path.

    Raises:
        MapError: The format or an option is invalid, the map is empty, a file of that name is no
            map's, or it cannot be written.
    """
    stem = Path(stem)
    _check_to_write(stem, grid, image_format, options)
    image_path, yaml_path = (stem.with_name(f"{stem.name}.{end}") for end in (image_format, "yaml"))
    origin = grid.frame.origin
    header = {
        "image": image_path.name,
        "mode": options.mode,
        "resolution": grid.frame.resolution,
        "origin": [origin.x, origin.y, origin.theta],
        "negate": int(options.negate),
        "occupied_thresh": options.occupied_thresh,
        "free_thresh": options.written_free_thresh,
    }
    try:
        _check_replaced(yaml_path, image_path)
        _write_pair(yaml_path, header, image_path, encoded(grid.data, options, image_format))
    except OSError as error:
        raise MapError(stem, f"cannot be written: {error.strerror}") from error
    return yaml_path, image_path


def _write_pair(
    yaml_path: Path, header: Mapping[str, Any], image_path: Path, content: bytes
) -> None:
    """Write a header and its image so that a kill at any point leaves the old pair or the new.

    While the image changes, the header names a copy of the new one beside it.
    """
    spare = _spare(image_path)
    if yaml_path.exists():
        write_atomically(spare, content)
        write_atomically(yaml_path, _header_text({**header, "image": spare.name}))
    write_atomically(image_path, content)
    write_atomically(yaml_path, _header_text(header))
    spare.unlink(missing_ok=True)


def _spare(image_path: Path) -> Path:
    return image_path.with_name(f".{image_path.name}.new")


def unnamed(now: float) -> str:
    """Return the name that map_saver gives a map without one, of the time [s]."""
    return f"map_{int(now)}"


def _check_replaced(yaml_path: Path, image_path: Path) -> None:
    """Refuse to write over files that are no map's."""
    header = _map_in(yaml_path)
    if header is None and yaml_path.exists():
        raise MapError(yaml_path, "is there and no map: it is not overwritten; choose another name")
    named = header is not None and header["image"] in (image_path.name, _spare(image_path).name)
    if image_path.exists() and not named and not _is_pgm(image_path):
        problem = "is there and of no map: it is not overwritten; choose another name"
        raise MapError(image_path, problem)


def _map_in(path: Path) -> dict[str, Any] | None:
    try:
        header = read_yaml(path, MapError)
    except MapError:
        return None
    is_map = isinstance(header, dict) and all(key in header for key in _REQUIRED)
    return header if is_map else None


def _is_pgm(path: Path) -> bool:
    """Return whether a file is an image of maps; a kill may have left it without a header."""
    return head_of(path, 2, MapError) in (b"P2", b"P5")


def _header_text(header: Mapping[str, Any]) -> bytes:
    return yaml.safe_dump(dict(header), sort_keys=False, default_flow_style=None).encode()


def _check_to_write(
    stem: Path, grid: OccupancyGrid, image_format: str, options: MapOptions
) -> None:
    if image_format not in FORMATS:
        problem = f"image format {image_format!r} is unknown; valid: {', '.join(FORMATS)}"
        raise MapError(stem, problem)
    if options.mode not in MODES:
        raise MapError(stem, f"mode {options.mode!r} is unknown; valid: {', '.join(MODES)}")
    if not 0.0 <= options.free_thresh < options.occupied_thresh <= 1.0:
        raise MapError(stem, "must be 0 <= free_thresh < occupied_thresh <= 1", "thresholds")
    if not grid.data.size:
        raise MapError(stem, "the map is empty")
    if options.mode == "scale" and image_format != "png" and grid.unknown().any():
        problem = f"mode 'scale' has no shade for unknown in a {image_format} image; valid: png"
        raise MapError(stem, problem)
