"""The topics of the layers: subscribed while they are shown, read as late as can be."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from geometry_msgs.msg import PolygonStamped, PoseStamped, PoseWithCovarianceStamped
from nav2_msgs.msg import ParticleCloud
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from arjuna_core.ros import qos
from bringup.viewing.drawing.messages import DRAWN, SERIALIZED


@dataclass(frozen=True)
class Topic:
    """A topic of a layer.

    Attributes:
        name: The topic, relative to the viewer's namespace.
        anywhere: Whether a topic of the type by another name will do.
    """

    layer: str
    name: str
    kind: Any
    profile: Any
    anywhere: bool = False

    @property
    def type_name(self) -> str:
        """The type as `package/msg/Name`."""
        return f"{self.kind.__module__.partition('.')[0]}/msg/{self.kind.__name__}"


TOPICS = {
    "robot": Topic("robot", "robot_description", String, qos.LATCHED),
    "map": Topic("map", "map", OccupancyGrid, qos.LATCHED),
    "global_costmap": Topic("global_costmap", "global_costmap/costmap", OccupancyGrid, qos.LATCHED),
    "local_costmap": Topic("local_costmap", "local_costmap/costmap", OccupancyGrid, qos.LATCHED),
    "footprint": Topic(
        "local_costmap", "local_costmap/published_footprint", PolygonStamped, qos.DEFAULT
    ),
    "scan": Topic("scan", "scan", LaserScan, qos.SENSOR_SUBSCRIPTION, anywhere=True),
    "particles": Topic("particles", "particle_cloud", ParticleCloud, qos.SENSOR_SUBSCRIPTION),
    "belief": Topic("particles", "amcl_pose", PoseWithCovarianceStamped, qos.LATCHED),
    "slam_belief": Topic("particles", "pose", PoseWithCovarianceStamped, qos.DEFAULT),
    "plan": Topic("global_path", "plan", Path, qos.DEFAULT),
    "local_plan": Topic("local_path", "local_plan", Path, qos.DEFAULT),
    "rollouts": Topic("trajectories", "trajectories", MarkerArray, qos.DEFAULT),
    "samples": Topic("trajectories", "marker", MarkerArray, qos.DEFAULT),
    "goal": Topic("goals", "goal_pose", PoseStamped, qos.DEFAULT),
    "camera": Topic("camera", "camera/image_raw", Image, qos.SENSOR_SUBSCRIPTION, anywhere=True),
}


class Feed:
    """Keeps the newest message of each topic that is shown, serialized until it is taken.

    Args:
        names: Other names of topics, by the keys of `TOPICS`.
    """

    def __init__(self, node: Node, names: Mapping[str, str]) -> None:
        self._node = node
        self._topics = {
            key: replace(topic, name=names.get(key, topic.name)) for key, topic in TOPICS.items()
        }
        self._open: dict[str, tuple[str, Any]] = {}
        self._newest: dict[str, bytes] = {}

    def listen(self, layers: Collection[str]) -> None:
        """Subscribe to the topics of layers, and to no others."""
        wanted = {
            key: self._name(topic) for key, topic in self._topics.items() if topic.layer in layers
        }
        for key, (name, subscription) in list(self._open.items()):
            if wanted.get(key) != name:
                self._node.destroy_subscription(subscription)
                del self._open[key]
                self._newest.pop(key, None)
        for key in wanted.keys() - self._open.keys():
            topic = TOPICS[key]
            subscription = self._node.create_subscription(
                topic.kind,
                wanted[key],
                lambda data, key=key: self._newest.update({key: data}),
                topic.profile,
                raw=True,
            )
            self._open[key] = (wanted[key], subscription)

    def _name(self, topic: Topic) -> str:
        """Return a topic's name; where nobody publishes it, perhaps another of its type."""
        if topic.anywhere and not self._node.count_publishers(topic.name):
            for other, types in self._node.get_topic_names_and_types():
                if topic.type_name in types and self._node.count_publishers(other):
                    return str(other)
        return topic.name

    def take(self) -> Iterator[tuple[str, Any]]:
        """Yield the newest message of each topic since the last call: its key and a drawing.

        Messages that are not drawn come as they are; those that make no sense are logged.
        """
        newest, self._newest = self._newest, {}
        for key, data in newest.items():
            topic = TOPICS[key]
            raw = topic.type_name in SERIALIZED
            try:
                message = data if raw else deserialize_message(data, topic.kind)
                draw = DRAWN.get(topic.type_name)
                yield key, message if draw is None else draw(topic.name, message)
            except ValueError as error:
                self._node.get_logger().warning(f"{topic.name}: {error}")
