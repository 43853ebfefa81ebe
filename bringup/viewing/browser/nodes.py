"""viser's scene nodes: their names, and where they are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from arjuna_core.pose3 import Pose3

_CLOSE = 1e-4


def plain(name: str) -> str:
    """Return a name that is one step of a scene node's path."""
    return name.replace("/", "|") or "|"


def put(handle: Any, pose: Pose3) -> None:
    """Move a node, if it is elsewhere."""
    if not np.allclose(handle.position, pose.position, rtol=0.0, atol=_CLOSE):
        handle.position = pose.position
    if not np.allclose(handle.wxyz, pose.quaternion, rtol=0.0, atol=_CLOSE):
        handle.wxyz = pose.quaternion


def remove(handles: Iterable[Any]) -> None:
    """Remove nodes from the scene."""
    for handle in handles:
        handle.remove()
