"""Listens to the frames of a robot: who is whose child, how often, how late."""

from __future__ import annotations

from typing import Any

from rclpy.qos import QoSProfile
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from bringup.client.session import Session
from bringup.viewing.frame_tree import Frame


class FrameListener:
    """Takes what comes on tf and tf_static from now on; another publisher's twin shows too."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._since = session.now
        self._parents: dict[str, dict[str, None]] = {}
        self._stamps: dict[str, list[float]] = {}
        self._static: dict[str, bool] = {}
        self._listen("tf", qos.TF, False)
        self._listen("tf_static", qos.TF_STATIC_SUBSCRIPTION, True)

    def _listen(self, topic: str, profile: QoSProfile, static: bool) -> None:
        def take(message: Any) -> None:
            for item in message.transforms:
                child = item.child_frame_id.lstrip("/")
                parents = self._parents.setdefault(child, {})
                parent = item.header.frame_id.lstrip("/")
                parents.pop(parent, None)
                parents[parent] = None
                self._static[child] = static
                self._stamps.setdefault(child, []).append(seconds(item.header.stamp))

        self._session.client.create_subscription(TFMessage, topic, take, profile)

    @property
    def found(self) -> bool:
        """True once any frame has been received."""
        return bool(self._stamps)

    def frames(self, now: float | None) -> dict[str, Frame]:
        """Return the frames that have come so far.

        Args:
            now: The robot's time [s]; None for the newest stamp.
        """
        moving = [stamps[-1] for name, stamps in self._stamps.items() if not self._static[name]]
        time = max(moving, default=0.0) if now is None else now
        passed = max(self._session.now - self._since, 1e-3)
        return {
            name: Frame(
                name,
                tuple(self._parents[name]),
                self._static[name],
                len(stamps) / passed,
                time - stamps[-1],
            )
            for name, stamps in self._stamps.items()
        }
