"""The geometry of cameras."""

from __future__ import annotations

from image_geometry.cameramodels import PinholeCameraModel
