"""What is shown of each topic: subscribed while it is, read as late as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from geometry_msgs.msg import PolygonStamped, PoseStamped, PoseWithCovarianceStamped
from nav2_msgs.msg import ParticleCloud
from nav_msgs.msg import OccupancyGrid as GridMsg
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import String

from arjuna_core.grid import OccupancyGrid
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    covariance_from_pose,
    grid_from_msg,
    poses_from_path,
    scan_from_msg,
    se2_from_pose,
    seconds,
)
from bringup.viewing.drawing import shapes, textures
from bringup.viewing.drawing.values import Arrows, Colour, Drawing, Lines, Overlay, Picture, Points

GOAL_COLOUR: Colour = (220, 40, 180)
GOAL_LENGTH = 0.5
_SCAN, _PARTICLES, _BELIEF = (230, 30, 30), (70, 170, 60), (150, 60, 200)
_GLOBAL, _LOCAL, _FOOTPRINT = (20, 160, 60), (30, 110, 240), (30, 30, 30)
_MAP = textures.map_palette()
_GLOBAL_COSTS, _LOCAL_COSTS = textures.costmap_palette(0.45), textures.costmap_palette(0.65)


@dataclass(frozen=True)
class Topic:
    """A topic of a layer.

    Attributes:
        layer: The layer.
        name: The topic, relative to the viewer's namespace.
        kind: Its message type.
        profile: Quality of service to ask for.
        draw: Returns what is drawn of a message; None passes the message on as it is.
        anywhere: Whether a topic of the type by another name will do.
        raw: Whether `draw` takes the serialized bytes.
    """

    layer: str
    name: str
    kind: Any
    profile: Any
    draw: Callable[[Any], Drawing] | None
    anywhere: bool = False
    raw: bool = False


def _map(message: Any) -> Drawing:
    grid = grid_from_msg(message)
    size = _size(grid)
    glb = textures.rectangle_glb(textures.grid_png(grid, _MAP), *size)
    return Picture(
        frame=_frame(message), pose=Pose3.from_se2(grid.frame.origin), glb=glb, size=size
    )


def _costmap(message: Any, palette: textures.Palette, z: float) -> Drawing:
    grid = grid_from_msg(message)
    size = _size(grid)
    pixels = textures.grid_pixels(grid, palette)
    middle = Pose3.from_se2(grid.frame.origin, z) @ Pose3((size[0] / 2, size[1] / 2, 0.0))
    return Overlay(frame=_frame(message), pose=middle, pixels=pixels, size=size)


def _size(grid: OccupancyGrid) -> tuple[float, float]:
    frame = grid.frame
    return frame.width * frame.resolution, frame.height * frame.resolution


def _scan(message: Any) -> Drawing:
    points = shapes.scan_points(scan_from_msg(message))
    stamp = seconds(message.header.stamp)
    return Points(frame=_frame(message), stamp=stamp, points=points, colour=_SCAN, size=0.05)


def _particles(data: bytes) -> Drawing:
    frame, poses = shapes.particles_from_cdr(data)
    arrows = shapes.arrows(poses, 0.12, 0.03)
    return Lines(frame=frame.lstrip("/"), segments=arrows, colour=_PARTICLES, width=1.5)


def _belief(message: Any) -> Drawing:
    pose = se2_from_pose(message.pose.pose)
    outline = shapes.ellipse(covariance_from_pose(message.pose.covariance), 0.04)
    outline[:, :, :2] += (pose.x, pose.y)
    return Lines(frame=_frame(message), segments=outline, colour=_BELIEF)


def _path(message: Any, colour: Colour, z: float) -> Drawing:
    segments = shapes.polyline(poses_from_path(message), z)
    return Lines(frame=_frame(message), segments=segments, colour=colour, width=4.0)


def _footprint(message: Any) -> Drawing:
    corners = np.array([[p.x, p.y] for p in message.polygon.points], dtype=np.float64)
    segments = shapes.polyline(corners.reshape(-1, 2), 0.05, closed=True)
    return Lines(frame=_frame(message), segments=segments, colour=_FOOTPRINT, width=2.0)


def _goal(message: Any) -> Drawing:
    segments = shapes.arrow(se2_from_pose(message.pose), GOAL_LENGTH, 0.06)
    return Arrows(frame=_frame(message), segments=segments, colour=GOAL_COLOUR)


def _frame(message: Any) -> str:
    return str(message.header.frame_id.lstrip("/"))


TOPICS = {
    "robot": Topic("robot", "robot_description", String, qos.LATCHED, None),
    "map": Topic("map", "map", GridMsg, qos.LATCHED, _map),
    "global_costmap": Topic(
        *("global_costmap", "global_costmap/costmap", GridMsg, qos.LATCHED),
        lambda m: _costmap(m, _GLOBAL_COSTS, 0.01),
    ),
    "local_costmap": Topic(
        *("local_costmap", "local_costmap/costmap", GridMsg, qos.LATCHED),
        lambda m: _costmap(m, _LOCAL_COSTS, 0.02),
    ),
    "footprint": Topic(
        *("local_costmap", "local_costmap/published_footprint", PolygonStamped),
        *(qos.DEFAULT, _footprint),
    ),
    "scan": Topic("scan", "scan", LaserScan, qos.SENSOR_SUBSCRIPTION, _scan, anywhere=True),
    "particles": Topic(
        *("particles", "particle_cloud", ParticleCloud, qos.SENSOR_SUBSCRIPTION, _particles),
        raw=True,
    ),
    "belief": Topic("particles", "amcl_pose", PoseWithCovarianceStamped, qos.LATCHED, _belief),
    "slam_belief": Topic("particles", "pose", PoseWithCovarianceStamped, qos.DEFAULT, _belief),
    "plan": Topic("global_path", "plan", Path, qos.DEFAULT, lambda m: _path(m, _GLOBAL, 0.03)),
    "local_plan": Topic(
        *("local_path", "local_plan", Path, qos.DEFAULT),
        lambda m: _path(m, _LOCAL, 0.05),
    ),
    "goal": Topic("goals", "goal_pose", PoseStamped, qos.DEFAULT, _goal),
    "camera": Topic(
        *("camera", "camera/image_raw", Image, qos.SENSOR_SUBSCRIPTION, None), anywhere=True
    ),
}


class Feed:
    """Keeps the newest message of each topic that is shown, serialized until it is taken.

    Args:
        node: The viewer's node.
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
            package = topic.kind.__module__.partition(".")[0]
            type_name = f"{package}/msg/{topic.kind.__name__}"
            for other, types in self._node.get_topic_names_and_types():
                if type_name in types and self._node.count_publishers(other):
                    return str(other)
        return topic.name

    def take(self) -> Iterator[tuple[str, Any]]:
        """Yield each message that came since the last call, its newest only, as it is drawn.

        A message that cannot be drawn is left out, as its own node would say.
        """
        newest, self._newest = self._newest, {}
        for key, data in newest.items():
            topic = TOPICS[key]
            try:
                message = data if topic.raw else deserialize_message(data, topic.kind)
                yield key, message if topic.draw is None else topic.draw(message)
            except ValueError as error:
                self._node.get_logger().warning(f"{topic.name}: {error}")
