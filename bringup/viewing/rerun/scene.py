"""A robot's messages, one by one, in rerun."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rerun.blueprint as rrb

from arjuna_core.bags.decoder import DecodeError, Decoder
from arjuna_core.bags.topic import TopicInfo
from bringup.viewing.displays.base import DISPLAYS
from bringup.viewing.displays.standard import usual
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.rerun import shapes
from bringup.viewing.rerun.stream import Stream

HANDLERS: dict[str, Callable[[Stream, str, Any], None]] = {
    "sensor_msgs/msg/Image": shapes.image,
    "sensor_msgs/msg/CompressedImage": shapes.compressed_image,
    "nav_msgs/msg/Odometry": lambda stream, topic, m: shapes.twist(stream, topic, m.twist.twist),
    "geometry_msgs/msg/Twist": shapes.twist,
    "geometry_msgs/msg/TwistStamped": lambda stream, topic, m: shapes.twist(stream, topic, m.twist),
    "arjuna_interfaces/msg/LocalizationQuality": shapes.quality,
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": shapes.feedback,
    "action_msgs/msg/GoalStatusArray": shapes.goal_status,
    "rcl_interfaces/msg/Log": shapes.log,
    "visualization_msgs/msg/MarkerArray": shapes.markers,
}
"""Shows the messages of a type otherwise than the browser's displays do."""
_KINDS = "Map LaserScan Path Polygon Pose PoseArray ParticleCloud PoseWithCovariance"
_DRAWN = {DISPLAYS.resolve(kind).types[0]: kind for kind in _KINDS.split()}
"""The displays of the other types that are shown."""
_PERIODS = {
    "sensor_msgs/msg/LaserScan": 0.09,
    "nav_msgs/msg/OccupancyGrid": 0.4,
    "nav_msgs/msg/Path": 0.15,
    "visualization_msgs/msg/MarkerArray": 0.4,
    "nav2_msgs/msg/ParticleCloud": 0.2,
    "geometry_msgs/msg/PoseArray": 0.2,
    "geometry_msgs/msg/PoseWithCovarianceStamped": 0.1,
    "geometry_msgs/msg/PolygonStamped": 0.15,
    "sensor_msgs/msg/Image": 0.19,
    "sensor_msgs/msg/CompressedImage": 0.19,
    "nav_msgs/msg/Odometry": 0.045,
    "geometry_msgs/msg/Twist": 0.045,
    "geometry_msgs/msg/TwistStamped": 0.045,
    "arjuna_interfaces/msg/LocalizationQuality": 0.09,
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": 0.2,
}
"""The least time between two messages of a topic that are shown, where not all are [s]."""
_TF, _STRING = "tf2_msgs/msg/TFMessage", "std_msgs/msg/String"


class Scene:
    """Shows messages in rerun; memory does not grow with time.

    Attributes:
        notes: On what cannot be shown, each once.
    """

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._decoder = Decoder()
        self._last: dict[str, float] = {}
        self._frames = Frames("map")
        self._root = ""
        self.notes: list[str] = []
        self.topics: set[str] = set()

    def shows(self, type_name: str) -> bool:
        """Return whether messages of a type are shown."""
        return type_name in _DRAWN or type_name in HANDLERS or type_name in (_TF, _STRING)

    def take(self, topic: TopicInfo, time: int, data: bytes) -> None:
        """Show a message that was received at a time [ns]."""
        self._stream.at(time)
        if not self.shows(topic.type_name) or not self._due(topic):
            return
        try:
            self._show(topic, data)
            self.topics.add(topic.name)
        except (DecodeError, ValueError) as error:
            self._note(f"{topic.name}: {error}")

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def _show(self, topic: TopicInfo, data: bytes) -> None:
        kind, name, stream = topic.type_name, topic.name, self._stream
        display = usual(_DRAWN[kind], name).make() if kind in _DRAWN else None
        raw = display is not None and display.raw
        message: Any = data if raw else self._decoder.decode(topic, data)
        if display is not None:
            for drawing in (display.take(message) or {}).values():
                shapes.draw(stream, name, drawing)
        elif kind == _TF:
            if shapes.transforms(stream, self._frames, message, name.endswith("tf_static")):
                self._orient()
        elif kind == _STRING and name.endswith("robot_description"):
            for note in shapes.robot(stream, message.data):
                self._note(note)
        elif kind == _STRING:
            shapes.text(stream, name, message)
        else:
            HANDLERS[kind](stream, name, message)
            if name.endswith("ground_truth/odom"):
                shapes.errors(stream, self._frames, message)

    def _due(self, topic: TopicInfo) -> bool:
        period, now = _PERIODS.get(topic.type_name, 0.0), self._stream.now
        if abs(now - self._last.get(topic.name, -period)) < period:
            return False
        self._last[topic.name] = now
        return True

    def _orient(self) -> None:
        """Show everything in the root frame, which changes as maps appear."""
        root = self._frames.fixed
        if root and root != self._root:
            self._root = root
            self._stream.recording.send_blueprint(blueprint(root))


def blueprint(frame: str) -> rrb.Blueprint:
    """Return the layout: the room in a frame on the left, pictures, curves and words beside it."""
    room = rrb.Spatial3DView(
        name="Room",
        origin="/",
        contents=["+ /**", "- /camera/**", "- /curves/**", "- /logs/**", "- /states/**"],
        spatial_information=rrb.archetypes.SpatialInformation(target_frame=frame),
        eye_controls=rrb.archetypes.EyeControls3D(
            position=(-4.0, -6.0, 9.0), look_target=(0.0, 0.0, 0.0), eye_up=(0.0, 0.0, 1.0)
        ),
        line_grid=False,
    )
    right = rrb.Vertical(
        rrb.Spatial2DView(name="Camera", origin="/camera"),
        rrb.Tabs(
            rrb.TimeSeriesView(name="Speed [m/s]", origin=f"/{shapes.SPEED}"),
            rrb.TimeSeriesView(name="Turn rate [rad/s]", origin=f"/{shapes.TURN}"),
        ),
        rrb.Tabs(
            rrb.TimeSeriesView(name="Error [m], [rad]", origin=f"/{shapes.ERROR}"),
            rrb.TimeSeriesView(name="To the goal", origin=f"/{shapes.GOAL}"),
        ),
        rrb.StateTimelineView(name="Actions", origin="/states"),
        rrb.TextLogView(name="Words", origin="/logs"),
        row_shares=[3, 3, 3, 2, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(room, right, column_shares=[3, 2]),
        rrb.TimePanel(timeline="time"),
        collapse_panels=True,
    )
