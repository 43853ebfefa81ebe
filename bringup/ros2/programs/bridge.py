"""`ros2 run ros_gz_bridge parameter_bridge`: topics of the simulator under the names of a bridge.

The simulator publishes ROS's messages itself, on the topics that the robot's file names. So only
where a bridge, or Gazebo by a model's name, calls a topic otherwise is there something to do.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from bringup.ros2.client import Client, absolute
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import ros_arguments

_TOPIC = re.compile(r"(?P<topic>[^@]+)@(?P<type>[^@\[\]]+)(?P<direction>[@\[\]])[^@\[\]]+")
_OF_MODEL = re.compile(r"/model/(?P<model>[^/]+)/(?P<topic>cmd_vel|odometry|tf)")
_OWN = {
    "cmd_vel": ("cmd_vel", "ROS_TO_GZ"),
    "odometry": ("odom", "GZ_TO_ROS"),
    "tf": ("tf", "GZ_TO_ROS"),
}
"""The robot's topic for each of Gazebo's, and its direction."""
_DIRECTIONS = {"[": "GZ_TO_ROS", "]": "ROS_TO_GZ", "@": "BIDIRECTIONAL"}


class Bridged(NamedTuple):
    """A topic under two names.

    Attributes:
        direction: `GZ_TO_ROS`, `ROS_TO_GZ` or `BIDIRECTIONAL`.
    """

    gz: str
    ros: str
    kind: str
    direction: str


def bridged(words: list[str]) -> Iterator[Bridged]:
    """Yield what a bridge's arguments and its `config_file` say.

    Raises:
        Ros2Error: An argument or an entry is none.
    """
    given = ros_arguments(words)
    for word in given.own:
        found = _TOPIC.fullmatch(word)
        if found is None:
            raise Ros2Error(f"'{word}' is no topic; valid: /topic@package/msg/Type[gz.msgs.Type")
        topic = found["topic"]
        ros = given.remapped.get(topic.lstrip("/"), topic)
        yield Bridged(
            absolute(topic), absolute(ros), found["type"], _DIRECTIONS[found["direction"]]
        )
    config = given.parameters.get("config_file", "")
    for entry in (read_yaml(Path(config)) or ()) if config else ():
        names = entry if isinstance(entry, dict) else {}
        topic = names.get("topic_name", "")
        ros, gz = (str(names.get(f"{side}_topic_name", topic)) for side in ("ros", "gz"))
        if not ros or not gz or not names.get("ros_type_name"):
            problem = "needs ros_topic_name, gz_topic_name (or topic_name) and ros_type_name"
            raise Ros2Error(f"{config}: the entry {entry} {problem}")
        ros = given.remapped.get(ros.lstrip("/"), ros)
        direction = str(names.get("direction", "BIDIRECTIONAL"))
        yield Bridged(absolute(gz), absolute(ros), str(names["ros_type_name"]), direction)


def simulated(node: Any, topic: Bridged) -> Bridged | None:
    """Return a topic by the simulator's name of it; None while the robot is not there.

    Gazebo names topics of a robot whose file names none after its model; here they are the robot's
    own, below its namespace where there are several robots.
    """
    found = _OF_MODEL.fullmatch(topic.gz)
    if found is None:
        return topic
    own, direction = _OWN[found["topic"]]
    count = node.count_subscribers if direction == "ROS_TO_GZ" else node.count_publishers
    for name in (topic.gz, f"/{found['model']}/{own}", f"/{own}"):
        if count(name):
            return topic._replace(gz=name, direction=direction)
    return None


class Relay:
    """Hands a topic's messages on, raw or not, under another name while somebody wants them."""

    def __init__(self, node: Any, topic: Bridged, raw: bool = True) -> None:
        self._node, self._raw = node, raw
        self._kind = class_of(topic.kind)
        hears = node.count_subscribers(topic.gz) and not node.count_publishers(topic.gz)
        is_out = topic.direction == "GZ_TO_ROS" or (
            topic.direction == "BIDIRECTIONAL" and not hears
        )
        self._source, target = (topic.gz, topic.ros) if is_out else (topic.ros, topic.gz)
        self._profile = qos.SENSOR_SUBSCRIPTION if is_out else qos.DEFAULT
        self._out = node.create_publisher(self._kind, target, qos.DEFAULT)
        self._subscription: Any = None

    def look(self) -> None:
        """Listen where the new name has subscribers, else not: pictures cost time."""
        wanted = self._out.get_subscription_count() > 0
        if wanted and self._subscription is None:
            arguments = self._kind, self._source, self._out.publish, self._profile
            self._subscription = self._node.create_subscription(*arguments, raw=self._raw)
        elif not wanted and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None


def main(words: list[str]) -> None:
    """Hand on what has two names until interrupted."""
    waiting, relays = list(bridged(words)), list[Relay]()
    with Client(name="ros_gz_bridge") as client:
        client.discover()
        while True:
            found = {topic: known for topic in waiting if (known := simulated(client.node, topic))}
            waiting = [topic for topic in waiting if topic not in found]
            for topic in found.values():
                if topic.gz != topic.ros:
                    relays.append(Relay(client.node, topic))
                    print(f"{topic.gz} is {topic.ros} too ({topic.direction})", flush=True)
            if found and not waiting and not relays:
                print("nothing to do: the simulator publishes ROS's topics itself", flush=True)
            for relay in relays:
                relay.look()
            client.pause(0.5)
