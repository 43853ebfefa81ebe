"""Moving keyframes by hand in RViz: interactive markers, and what becomes of them."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Quaternion
from sensor_msgs.msg import LaserScan
from slam_toolbox.srv import Clear, LoopClosure, ToggleInteractive
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    InteractiveMarkerUpdate,
    Marker,
)
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_msg, scan_msg, se2_from_pose, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import transforms_msg
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.slam_output import NODE_COLOR

SCAN_FRAME = "scan_visualization"
_SERVER = "slam_toolbox"
_UPRIGHT = Quaternion(w=0.7071067811865476, y=0.7071067811865476)  # a control's x axis along z
_FACE_UP = (
    (InteractiveMarkerControl.MOVE_PLANE, "move"),
    (InteractiveMarkerControl.ROTATE_AXIS, "turn"),
)


class InteractiveGraph:
    """Offers keyframes as interactive markers, and `manual_loop_closure` of those that were moved.

    It is off at first; where `enable_interactive_mode` allows it, a service turns it on and off.
    While it is on, no scans are taken in: the graph does not change under the hand.

    Args:
        node: The slam_toolbox node, whose `slam` has the graph.

    Attributes:
        on: Whether keyframes can be moved.
    """

    def __init__(self, node: ManagedNode) -> None:
        self._node: Any = node
        self.on = False
        self._moved: dict[int, SE2] = {}
        self._sequence = self._shown = 0
        profile = qos.DEFAULT
        self._updates = node.publisher(InteractiveMarkerUpdate, f"{_SERVER}/update", profile)
        self._scan = node.publisher(LaserScan, f"{_SERVER}/scan_visualization", qos.DEFAULT)
        self._tf = node.publisher(TFMessage, "/tf", qos.TF)
        node.subscribe(
            InteractiveMarkerFeedback, f"{_SERVER}/feedback", self._on_feedback, qos.DEFAULT
        )
        node.serve(GetInteractiveMarkers, f"{_SERVER}/get_interactive_markers", self._on_get)
        node.serve(ToggleInteractive, f"{_SERVER}/toggle_interactive_mode", self._on_toggle)
        node.serve(LoopClosure, f"{_SERVER}/manual_loop_closure", self._on_close)
        node.serve(Clear, f"{_SERVER}/clear_changes", self._on_clear)

    def forget(self) -> None:
        """Forget what was moved: the graph is another."""
        self._moved.clear()
        self._publish()

    def show_scan(self, scan: Scan, T_map_base: SE2) -> None:
        """Show a scan where its keyframe is, to who asks."""
        if not self._scan.get_subscription_count():
            return
        now = self._node.now
        sensor = T_map_base @ scan.T_base_sensor
        frame = transform_msg(sensor, self._node.config.map_frame, SCAN_FRAME, now)
        self._tf.publish(transforms_msg(frame))
        message = scan_msg(scan, SCAN_FRAME, 0.0)
        message.header = header(SCAN_FRAME, now)
        self._scan.publish(message)

    def _refused(self, service: str) -> bool:
        """Say that a service needs the interactive mode; return whether it is not allowed."""
        if self._node.config.enable_interactive_mode:
            return False
        self._node.get_logger().warning(f"{service} needs enable_interactive_mode: true")
        return True

    def _on_toggle(self, request: Any, response: Any) -> Any:
        if self._refused("toggle_interactive_mode"):
            return response
        self.on = not self.on
        self._moved.clear()
        self._publish()
        state = "on: scans are ignored" if self.on else "off: scans are taken in"
        self._node.get_logger().info(f"interactive mode {state}")
        return response

    def _on_feedback(self, message: Any) -> None:
        graph = self._node.slam.graph
        name = message.marker_name
        if not self.on or not name.isdigit() or int(name) >= len(graph):
            return
        try:
            pose = se2_from_pose(message.pose)
        except ValueError as error:
            self._node.get_logger().warning(f"keyframe {name} not moved: {error}")
            return
        if message.event_type in (message.POSE_UPDATE, message.MOUSE_UP):
            self._moved[int(name)] = pose
        self.show_scan(self._node.slam.keyframes.scans[int(name)], pose)

    def _on_close(self, request: Any, response: Any) -> Any:
        if self._refused("manual_loop_closure"):
            return response
        moved = dict(self._moved)
        self._moved.clear()
        closed = self._node.close_by_hand(moved)
        self._publish()
        if len(moved) > closed:
            self._node.get_logger().warning(
                f"{len(moved) - closed} of {len(moved)} moved keyframes do not fit where they "
                "were put: they stay as they were"
            )
        return response

    def _on_clear(self, request: Any, response: Any) -> Any:
        if self._refused("clear_changes"):
            return response
        self._node.get_logger().info(f"{len(self._moved)} moved keyframes put back")
        self.forget()
        return response

    def _on_get(self, request: Any, response: Any) -> Any:
        response.sequence_number = self._sequence
        response.markers = self._markers()
        return response

    def _publish(self) -> None:
        if not (self.on or self._shown):
            return
        self._sequence += 1
        update = InteractiveMarkerUpdate(server_id=_SERVER, seq_num=self._sequence)
        update.type = InteractiveMarkerUpdate.UPDATE
        if self.on:
            update.markers = self._markers()
        else:
            update.erases = [str(k) for k in range(self._shown)]
        self._shown = len(update.markers)
        self._updates.publish(update)

    def _markers(self) -> list[InteractiveMarker]:
        if not self.on:
            return []
        graph, c = self._node.slam.graph, self._node.config
        head = header(c.map_frame, self._node.now)
        poses = [self._moved.get(k, graph.pose(k)) for k in range(len(graph))]
        return [handle(head, str(k), pose) for k, pose in enumerate(poses)]


def handle(head: Any, name: str, pose: SE2, diameter: float = 0.2) -> InteractiveMarker:
    """Return a ball of a diameter [m] that can be moved and turned in the plane."""
    marker = InteractiveMarker(header=head, name=name, description=name, scale=2.5 * diameter)
    marker.pose = pose_msg(pose)
    ball = Marker(type=Marker.SPHERE, color=NODE_COLOR)
    ball.scale.x = ball.scale.y = ball.scale.z = diameter
    for mode, control_name in _FACE_UP:
        control = InteractiveMarkerControl(name=control_name, interaction_mode=mode)
        control.orientation = _UPRIGHT
        control.always_visible = True
        marker.controls.append(control)
    marker.controls[0].markers = [ball]
    return marker
