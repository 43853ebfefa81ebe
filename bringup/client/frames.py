"""Listens to the frames of a robot: who is whose child, how often, how late."""

from __future__ import annotations

from typing import Any

from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
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
        self._statics: dict[str, set[tuple[float, ...]]] = {}
        self._clock: float | None = None
        session.client.create_subscription(Clock, "clock", self._on_clock, qos.CLOCK)
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
                if static:
                    self._statics.setdefault(child, set()).add(_values(item.transform))
                self._stamps.setdefault(child, []).append(seconds(item.header.stamp))

        self._session.client.create_subscription(TFMessage, topic, take, profile)

    def _on_clock(self, message: Any) -> None:
        self._clock = seconds(message.clock)

    @property
    def found(self) -> bool:
        """True once any frame has been received."""
        return bool(self._stamps)

    def frames(self, now: float | None) -> dict[str, Frame]:
        """Return the frames so far, at a time [s]; if None that of /clock, or the newest stamp."""
        moving = [stamps[-1] for name, stamps in self._stamps.items() if not self._static[name]]
        now = self._clock if now is None else now
        time = max(moving, default=0.0) if now is None else now
        passed = max(self._session.now - self._since, 1e-3)
        return {
            name: Frame(
                name,
                tuple(self._parents[name]),
                self._static[name],
                len(stamps) / passed,
                time - stamps[-1],
                len(self._statics.get(name, ())),
            )
            for name, stamps in self._stamps.items()
        }


def _values(transform: Any) -> tuple[float, ...]:
    """Return a transform's numbers [m], rounded to what two writers of one pose agree on."""
    t, q = transform.translation, transform.rotation
    return tuple(round(value, 6) for value in (t.x, t.y, t.z, q.x, q.y, q.z, q.w))
