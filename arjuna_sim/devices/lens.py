"""Lenses that distort: pictures as a camera has them, of pictures as an ideal one would."""

from __future__ import annotations

import numpy as np

from arjuna_core.arrays import Bytes, Floats
from arjuna_sim.devices.sensors.camera import CameraSettings

_ROUNDS = 30  # of the search for where a pixel looks, which mostly takes five
_SIDE_MAX = 2.0  # the ideal picture's sides, by the camera's: what is beyond stays black


class Lens:
    """A lens of the model `plumb_bob`, about the picture's middle.

    Source: D. Brown, Decentering distortion of lenses, Photogrammetric Engineering 32(3), 1966;
    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and so for y.

    Attributes:
        width: Of the ideal picture that it takes, of the same focal length [pixels].
        height: Its height [pixels].
    """

    def __init__(self, settings: CameraSettings, focal_length: float) -> None:
        width, height = settings.width, settings.height
        x, y = ((np.arange(size) + 0.5 - size / 2) / focal_length for size in (width, height))
        wanted = np.stack(np.meshgrid(x, y))
        seen = wanted.copy()
        with np.errstate(all="ignore"):
            for _ in range(_ROUNDS):
                seen += wanted - distorted(seen, settings.distortion)
            off = np.abs(distorted(seen, settings.distortion) - wanted).max(axis=0)
            reach = np.where(off * focal_length < 0.5, np.abs(seen), 0.0).max(axis=(1, 2))
        sizes = np.ceil(2.0 * reach * focal_length) + 2.0
        self.width, self.height = (
            int(np.clip(size, own, _SIDE_MAX * own)) // 2 * 2
            for size, own in zip(sizes, (width, height), strict=True)
        )
        at = seen * focal_length + np.array([self.width, self.height])[:, None, None] / 2 - 0.5
        top = np.array([self.width, self.height])[:, None, None] - 1.0
        self._black = ~((at >= 0.0) & (at <= top) & (off * focal_length < 0.5)).all(axis=0)
        at = np.where(self._black, 0.0, at)
        whole = np.minimum(np.floor(at), top - 1.0)
        self._column, self._row = whole.astype(np.int64)
        self._right, self._down = ((at - whole)[..., None]).astype(np.float32)

    def picture(self, ideal: Bytes) -> Bytes:
        """Return what the camera sees of an ideal picture `(height, width, 3) uint8`, both RGB."""
        row, column, right = self._row, self._column, self._right
        upper, lower = (
            ideal[row + i, column] * (1.0 - right) + ideal[row + i, column + 1] * right
            for i in (0, 1)
        )
        mixed = upper + (lower - upper) * self._down
        mixed[self._black] = 0.0
        return np.asarray(np.rint(mixed), np.uint8)


def distorted(points: Floats, distortion: tuple[float, ...]) -> Floats:
    """Return where a lens shows points of the plane at distance 1, `(2, ...) float64`.

    Args:
        distortion: k1, k2, p1, p2 and k3, as in `sensor_msgs/CameraInfo`.
    """
    (k1, k2, p1, p2, k3), (x, y) = distortion, points
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.stack(
        (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    )
