"""The server of interactive markers: what it shows, and who is called when one is moved.

Source: the interactive_markers package of Jazzy, its names, topics and rules.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from threading import RLock

from geometry_msgs.msg import Pose
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.time import Time
from std_msgs.msg import Header
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)
from visualization_msgs.srv import GetInteractiveMarkers

Callback = Callable[[InteractiveMarkerFeedback], object]


@dataclass
class _Shown:
    """A marker that clients have, and who moved it last."""

    marker: InteractiveMarker
    client: str = ""
    moved: Time | None = None


@dataclass
class _Pending:
    """Changes that clients get at the next `applyChanges`."""

    markers: dict[str, InteractiveMarker] = field(default_factory=dict)
    poses: dict[str, InteractiveMarkerPose] = field(default_factory=dict)
    erased: dict[str, None] = field(default_factory=dict)


class InteractiveMarkerServer:
    """Markers on `<namespace>/update`, their clients' answers from `<namespace>/feedback`."""

    DEFAULT_FEEDBACK_CALLBACK = 255

    def __init__(
        self,
        node: Node,
        namespace: str,
        *,
        update_pub_qos: QoSProfile | None = None,
        feedback_sub_qos: QoSProfile | None = None,
    ) -> None:
        self.node, self.topic_ns, self.seq_num = node, namespace, 0
        self.mutex = RLock()
        self._shown: dict[str, _Shown] = {}
        self._pending = _Pending()
        self._callbacks: dict[str, dict[int, Callback]] = {}
        self.update_pub = node.create_publisher(
            InteractiveMarkerUpdate, f"{namespace}/update", update_pub_qos or QoSProfile(depth=100)
        )
        self.get_interactive_markers_srv = node.create_service(
            GetInteractiveMarkers, f"{namespace}/get_interactive_markers", self._answer
        )
        self.feedback_sub = node.create_subscription(
            InteractiveMarkerFeedback,
            f"{namespace}/feedback",
            self.processFeedback,
            feedback_sub_qos or QoSProfile(depth=1),
        )

    def shutdown(self) -> None:
        """Take all markers from the clients and close the topics."""
        self.clear()
        self.applyChanges()
        self.node.destroy_service(self.get_interactive_markers_srv)
        self.node.destroy_subscription(self.feedback_sub)
        self.node.destroy_publisher(self.update_pub)

    def insert(
        self,
        marker: InteractiveMarker,
        *,
        feedback_callback: Callback | None = None,
        feedback_type: int = DEFAULT_FEEDBACK_CALLBACK,
    ) -> None:
        """Add a marker, or replace the one of its name, at the next `applyChanges`."""
        with self.mutex:
            self._pending.markers[marker.name] = marker
            self._pending.poses.pop(marker.name, None)
            self._pending.erased.pop(marker.name, None)
            if feedback_callback is not None:
                self.setCallback(marker.name, feedback_callback, feedback_type)

    def setPose(self, name: str, pose: Pose, header: Header | None = None) -> bool:
        """Move a marker at the next `applyChanges`; False where there is none of that name."""
        with self.mutex:
            marker = self.get(name)
            if marker is None:
                return False
            header = header if header is not None and header.frame_id else marker.header
            if name in self._pending.markers:
                marker = self._pending.markers[name]
                marker.pose, marker.header = pose, header
            else:
                moved = InteractiveMarkerPose(header=header, pose=pose, name=name)
                self._pending.poses[name] = moved
            return True

    def erase(self, name: str) -> bool:
        """Take a marker away at the next `applyChanges`; False where there is none."""
        with self.mutex:
            known = name in self._shown or name in self._pending.markers
            self._pending.markers.pop(name, None)
            self._pending.poses.pop(name, None)
            if known:
                self._pending.erased[name] = None
            return known

    def clear(self) -> None:
        """Take all markers away at the next `applyChanges`."""
        for name in {**self._shown, **self._pending.markers}:
            self.erase(name)

    def setCallback(
        self,
        name: str,
        feedback_callback: Callback | None,
        feedback_type: int = DEFAULT_FEEDBACK_CALLBACK,
    ) -> bool:
        """Have a function called with a marker's feedback of one kind, by default of all others."""
        with self.mutex:
            if name not in self._shown and name not in self._pending.markers:
                return False
            callbacks = self._callbacks.setdefault(name, {})
            if feedback_callback is None:
                callbacks.pop(feedback_type, None)
            else:
                callbacks[feedback_type] = feedback_callback
            return True

    def applyChanges(self) -> None:
        """Publish what has changed since the last call."""
        with self.mutex:
            pending, self._pending = self._pending, _Pending()
            if not (pending.markers or pending.poses or pending.erased):
                return
            for name, marker in pending.markers.items():
                self._shown.setdefault(name, _Shown(marker)).marker = deepcopy(marker)
            for name, moved in pending.poses.items():
                marker = self._shown[name].marker
                marker.pose, marker.header = moved.pose, moved.header
            for name in pending.erased:
                self._shown.pop(name, None)
                self._callbacks.pop(name, None)
            self.seq_num += 1
            update = InteractiveMarkerUpdate(
                server_id=self.node.get_fully_qualified_name() + "/" + self.topic_ns,
                seq_num=self.seq_num,
                type=InteractiveMarkerUpdate.UPDATE,
                markers=[deepcopy(each) for each in pending.markers.values()],
                poses=list(pending.poses.values()),
                erases=list(pending.erased),
            )
        self.update_pub.publish(update)

    def get(self, name: str) -> InteractiveMarker | None:
        """Return a copy of a marker with the changes that wait; None where there is none."""
        with self.mutex:
            if name in self._pending.markers:
                return deepcopy(self._pending.markers[name])
            if name not in self._shown or name in self._pending.erased:
                return None
            marker = deepcopy(self._shown[name].marker)
            if name in self._pending.poses:
                moved = self._pending.poses[name]
                marker.pose, marker.header = moved.pose, moved.header
            return marker

    def processFeedback(self, feedback: InteractiveMarkerFeedback) -> None:
        """Move a marker as a client dragged it, and call who waits for it.

        For a second after one client moved a marker, no other client does.
        """
        with self.mutex:
            shown, now = self._shown.get(feedback.marker_name), self.node.get_clock().now()
            if shown is None:
                return
            moved = shown.moved if shown.client != feedback.client_id else None
            if moved is not None and now - moved < Duration(seconds=1):
                return
            shown.moved, shown.client = now, feedback.client_id
            if feedback.event_type == InteractiveMarkerFeedback.POSE_UPDATE:
                stamp = shown.marker.header.stamp
                follows = stamp.sec == 0 and stamp.nanosec == 0  # its frame's motion
                header = shown.marker.header if follows else feedback.header
                self.setPose(feedback.marker_name, feedback.pose, header)
            callbacks = self._callbacks.get(feedback.marker_name, {})
            default = callbacks.get(self.DEFAULT_FEEDBACK_CALLBACK)
            callback = callbacks.get(feedback.event_type, default)
        if callback is not None:
            callback(feedback)

    def _answer(
        self, _: GetInteractiveMarkers.Request, response: GetInteractiveMarkers.Response
    ) -> GetInteractiveMarkers.Response:
        with self.mutex:
            response.sequence_number = self.seq_num
            response.markers = [deepcopy(each.marker) for each in self._shown.values()]
        return response
