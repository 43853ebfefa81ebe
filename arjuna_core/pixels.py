"""A camera's image message as pixels."""

from __future__ import annotations

from typing import Any

import numpy as np

from arjuna_core.arrays import Bytes, Floats

_CHANNELS = {"rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "rgba8": (0, 1, 2), "bgra8": (2, 1, 0)}
_COUNTS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1}
_DEPTHS: dict[str, np.dtype[Any]] = {
    "32FC1": np.dtype("<f4"),
    "16UC1": np.dtype("<u2"),
    "mono16": np.dtype("<u2"),
}


def pixels(
    encoding: str, height: int, width: int, step: int, data: bytes, widest: int | None = None
) -> Bytes:
    """Return an image as `(rows, columns, 3) uint8`, thinned to at most `widest` columns.

    Args:
        encoding: One of sensor_msgs/image_encodings' colours, greys or depths.
        height: Number of rows.
        width: Number of columns.
        step: Bytes of a row.
        data: The rows.
        widest: Columns at most [pixels]; None for all.

    Raises:
        ValueError: The encoding is not known, or the data is too short.
    """
    if encoding not in _COUNTS and encoding not in _DEPTHS:
        valid = ", ".join([*_COUNTS, *_DEPTHS])
        raise ValueError(f"an image in '{encoding}' is not shown; valid: {valid}")
    if len(data) < height * step:
        raise ValueError(f"{len(data)} bytes for an image of {height} rows of {step}")
    rows = np.frombuffer(data, np.uint8, height * step).reshape(height, step)
    thin = 1 if widest is None else max(1, -(-width // widest))
    if encoding in _DEPTHS:
        kind = _DEPTHS[encoding]
        depth = np.ascontiguousarray(rows[::thin, : width * kind.itemsize]).view(kind)
        return _grey(_bright(depth[:, ::thin].astype(np.float64)))
    count = _COUNTS[encoding]
    image = rows[:, : width * count].reshape(height, width, count)[::thin, ::thin]
    if count == 1:
        return _grey(image[:, :, 0])
    return np.ascontiguousarray(image[:, :, _CHANNELS[encoding]])


def _grey(values: Bytes) -> Bytes:
    return np.repeat(values[:, :, None], 3, axis=2)


def _bright(depth: Floats) -> Bytes:
    """Return depths as greys: near is bright, without a return is black."""
    valid = np.isfinite(depth) & (depth > 0.0)
    if not valid.any():
        return np.zeros(depth.shape, np.uint8)
    low, high = depth[valid].min(), depth[valid].max()
    share = (high - np.where(valid, depth, high)) / max(high - low, 1e-9)
    return np.where(valid, 40.0 + 215.0 * share, 0.0).astype(np.uint8)
