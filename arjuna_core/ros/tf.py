"""The process's transform listener: /tf and /tf_static into a buffer."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose3_from_transform, se2_from_transform, seconds
from arjuna_core.ros.health.rules import transform_problem
from arjuna_core.ros.messages import maker
from arjuna_core.timing import NANOSECONDS
from arjuna_core.transforms import TransformBuffer, TransformError

if TYPE_CHECKING:
    from arjuna_core.ros.health.guarded import GuardedNode

__all__ = [
    "TransformBuffer",
    "TransformError",
    "TransformListener",
    "TransformPublisher",
    "transforms_msg",
]

_made = maker(TFMessage, "transforms")


def transforms_msg(*transforms: TransformStamped) -> TFMessage:
    """Return transforms as a message of /tf."""
    return _made(list(transforms))


class TransformPublisher:
    """Publishes transforms below the robot's namespace, those of its own names to all robots too.

    Args:
        node: Has a `publisher`, a `process` and a `keep`, as a managed one.
    """

    def __init__(self, node: Any, topic: str, profile: Any) -> None:
        self._out = node.publisher(TFMessage, topic, profile)
        self._shared: Any = None
        self._namespace = node.process.namespace
        self._share = lambda: node.keep(node.create_publisher(TFMessage, topic, profile))

    def publish(self, message: TFMessage) -> None:
        """Publish a message of /tf or /tf_static."""
        self._out.publish(message)
        if self._namespace and any(_is_own(t, self._namespace) for t in message.transforms):
            self._shared = self._shared or self._share()
            self._shared.publish(message)


def _is_own(transform: TransformStamped, namespace: str) -> bool:
    """Return whether a transform's frame is one robot's by name, as `r1/odom`, or `r1_odom`."""
    frame = transform.child_frame_id.lstrip("/")
    return "/" in frame or frame.startswith(f"{namespace}_")


class TransformListener:
    """Feeds a buffer from tf and tf_static of a node's namespace, which is the robot's.

    Below a namespace those of all robots count too, where their frames are one's by name.

    Transforms that cannot be used, or contradict living frames or the clock, are refused and
    counted, each by itself.

    Args:
        now: Returns the time [s]; None for the node's clock.
        namespace: The robot's.
    """

    def __init__(
        self,
        node: GuardedNode,
        buffer: TransformBuffer,
        now: Callable[[], float] | None = None,
        namespace: str = "",
    ) -> None:
        self._node = node
        self._buffer = buffer
        self._transport = getattr(node, "transport", None)
        self._guard = getattr(node, "guard", None)  # a client's plain node has none
        self._now = now or (lambda: node.get_clock().now().nanoseconds / NANOSECONDS)
        for root in ("", "/") if namespace else ("",):
            for topic, profile in (("tf", qos.TF), ("tf_static", qos.TF_STATIC_SUBSCRIPTION)):
                take = partial(self._insert, static=topic != "tf", named=root and namespace)
                node.create_subscription(TFMessage, root + topic, take, profile)

    def _insert(self, message: Any, static: bool, named: str) -> None:
        trusted = self._transport is not None and self._transport.trusted
        now = self._now()
        for item in message.transforms:
            if named and not _is_own(item, named):
                continue
            parent, child = item.header.frame_id.lstrip("/"), item.child_frame_id.lstrip("/")
            stamp = seconds(item.header.stamp)
            problem = None if trusted else transform_problem(item)
            if problem := problem or self._buffer.admit(parent, child, stamp, static, now):
                if self._guard is not None:
                    self._guard.refused(self._node, "a transform", problem)
                continue
            self._buffer.insert(
                parent,
                child,
                stamp,
                se2_from_transform(item.transform),
                static,
                pose3_from_transform(item.transform),
                received=now,
            )
