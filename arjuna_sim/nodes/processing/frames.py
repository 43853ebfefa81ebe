"""Poses of sensors in other frames, for nodes that drop what comes without them."""

from __future__ import annotations

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError


class MountedFrames:
    """The newest poses of frames in each other, and one warning for each that is missing."""

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        self._reported: set[tuple[str, str]] = set()

    def mounted(self, target: str, frame: str) -> Pose3:
        """Return a frame's pose in another.

        Raises:
            TransformError: They are not connected.
        """
        target, frame = target.lstrip("/"), frame.lstrip("/")
        return ORIGIN if target in ("", frame) else self._node.transforms.mount(target, frame)

    def report(self, what: str, frame: str, error: TransformError) -> None:
        """Log once that what comes in a frame is dropped."""
        if (what, frame) not in self._reported:
            self._reported.add((what, frame))
            self._node.get_logger().warning(f"{what} of '{frame}' are dropped: {error}")
