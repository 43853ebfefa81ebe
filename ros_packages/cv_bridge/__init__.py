"""Images as NumPy arrays, and back."""

from __future__ import annotations

from cv_bridge.core import CvBridge, CvBridgeError
