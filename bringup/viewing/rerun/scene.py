"""What a robot says, message by message, as what rerun shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bringup.recording.bags.decoder import DecodeError, Decoder
from bringup.recording.bags.topic import TopicInfo
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.looks import FindMesh
from bringup.viewing.rerun import curves, shapes, words
from bringup.viewing.rerun.blueprint import blueprint
from bringup.viewing.rerun.robot import log_robot
from bringup.viewing.rerun.stream import Stream

Handler = Callable[[Stream, str, Any], None]
HANDLERS: dict[str, tuple[float, Handler]] = {
    "sensor_msgs/msg/LaserScan": (0.09, shapes.scan),
    "nav_msgs/msg/OccupancyGrid": (0.4, shapes.grid),
    "nav_msgs/msg/Path": (0.15, shapes.path),
    "nav2_msgs/msg/ParticleCloud": (0.2, shapes.particles),
    "geometry_msgs/msg/PoseArray": (0.2, shapes.poses),
    "geometry_msgs/msg/PoseStamped": (0.0, shapes.pose),
    "geometry_msgs/msg/PoseWithCovarianceStamped": (0.1, shapes.belief),
    "geometry_msgs/msg/PolygonStamped": (0.15, shapes.polygon),
    "sensor_msgs/msg/Image": (0.19, shapes.image),
    "sensor_msgs/msg/CompressedImage": (0.19, shapes.compressed_image),
    "nav_msgs/msg/Odometry": (0.045, curves.odometry),
    "geometry_msgs/msg/Twist": (0.045, curves.twist),
    "geometry_msgs/msg/TwistStamped": (0.045, curves.twist_stamped),
    "arjuna_interfaces/msg/LocalizationQuality": (0.09, curves.quality),
    "nav2_msgs/action/NavigateToPose_FeedbackMessage": (0.2, curves.feedback),
    "action_msgs/msg/GoalStatusArray": (0.0, words.goal_status),
    "rcl_interfaces/msg/Log": (0.0, words.log),
}
"""For each type the least time between two that are shown [s], and what shows it."""
_TF, _STRING = "tf2_msgs/msg/TFMessage", "std_msgs/msg/String"


class Scene:
    """Turns messages into what rerun shows; memory does not grow with time.

    Args:
        stream: Where it goes.
        find_mesh: Finds the robot's meshes.

    Attributes:
        notes: What cannot be shown, each once.
        topics: The topics that are shown.
    """

    def __init__(self, stream: Stream, find_mesh: FindMesh) -> None:
        self._stream = stream
        self._find_mesh = find_mesh
        self._decoder = Decoder()
        self._shown: dict[str, float] = {}
        self._frames = Frames("map")
        self._root = ""
        self.notes: list[str] = []
        self.topics: set[str] = set()

    def shows(self, topic: TopicInfo) -> bool:
        """Tell whether messages of a topic are shown."""
        return topic.type_name in HANDLERS or topic.type_name in (_TF, _STRING)

    def take(self, topic: TopicInfo, time: int, data: bytes) -> None:
        """Show a message.

        Args:
            topic: Its topic.
            time: When it was received [ns].
            data: Its bytes.
        """
        self._stream.at(time)
        try:
            self._show(topic, data)
        except (DecodeError, ValueError) as error:
            self._note(f"{topic.name}: {error}")

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def _show(self, topic: TopicInfo, data: bytes) -> None:
        kind = topic.type_name
        if kind == _TF:
            static = topic.name.endswith("tf_static")
            message = self._decoder.decode(topic, data)
            if shapes.transforms(self._stream, self._frames, message, static):
                self._orient()
        elif kind == _STRING and topic.name.endswith("robot_description"):
            message = self._decoder.decode(topic, data)
            for note in log_robot(self._stream, message.data, self._find_mesh):
                self._note(note)
        elif kind == _STRING:
            words.text(self._stream, topic.name, self._decoder.decode(topic, data))
        elif kind in HANDLERS and self._due(topic.name, HANDLERS[kind][0]):
            message = self._decoder.decode(topic, data)
            HANDLERS[kind][1](self._stream, topic.name, message)
            if topic.name.endswith("ground_truth/odom"):
                curves.errors(self._stream, self._frames, message)
        else:
            return
        self.topics.add(topic.name)

    def _due(self, topic: str, period: float) -> bool:
        now = self._stream.now
        if abs(now - self._shown.get(topic, -period)) < period:
            return False
        self._shown[topic] = now
        return True

    def _orient(self) -> None:
        """Show everything in the frame that all others hang on; that changes as maps appear."""
        root = self._frames.fixed
        if root and root != self._root:
            self._root = root
            self._stream.recording.send_blueprint(blueprint(root))
