"""Poses of sensors in other frames, for nodes that drop what comes without them."""

from __future__ import annotations

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError


class MountedFrames:
    """The newest poses of frames in each other, and one warning for each that is missing."""

    def __init__(self, node: ManagedNode) -> None:
        self._node = node
        self._unknown: set[tuple[str, str]] = set()

    def mounted(self, target: str, frame: str) -> Pose3:
        """Return a frame's pose in another.

        Raises:
            TransformError: They are not connected.
        """
        target, frame = target.lstrip("/"), frame.lstrip("/")
        return ORIGIN if frame in ("", target) else self._node.transforms.mount(target, frame)

    def mount(self, target: str, frame: str) -> Pose3 | None:
        """Return a frame's pose in another; warn once that there is none."""
        try:
            return self.mounted(target, frame)
        except TransformError as error:
            self.warn(target, frame, error)
            return None

    def warn(self, target: str, frame: str, error: TransformError) -> None:
        """Log once that what comes in a frame is not used yet."""
        if (target, frame) not in self._unknown:
            self._unknown.add((target, frame))
            self._node.get_logger().warning(f"what comes in '{frame}' is not used yet: {error}")
