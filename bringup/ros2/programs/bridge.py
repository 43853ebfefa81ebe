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
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.model.entities import POSES
from arjuna_sim.model.settings import BRIDGES, spelled
from bringup.ros2.client import Client, absolute, full_name
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import ros_arguments

_TOPIC = re.compile(r"(?P<topic>[^@]+)@(?P<type>[^@\[\]]+)(?P<direction>[@\[\]])[^@\[\]]+")
_OF_GAZEBO = re.compile(
    r"(/world/[^/]+)?/model/(?P<model>[^/]+)(/link/.+/sensor/(?P<sensor>[^/]+))?/(?P<topic>cmd_vel"
    r"|odometry|tf|joint_state|imu|scan(/points)?|image|camera_info|depth_image|points)"
)
_OF_MODEL = re.compile(r"/model/(?P<model>[^/]+)/(?P<topic>.+)")
_CLOCK = re.compile(r"/world/[^/]+/clock")
_OWN = {
    "odometry": "odom",
    "joint_state": "joint_states",
    "imu": ImuSettings.TOPIC,
    "image": CameraSettings.TOPIC,
    "camera_info": "camera/camera_info",
    "depth_image": "camera/depth/image_raw",
    "points": "camera/points",
}
"""The robot's topic for each of Gazebo's that is called otherwise."""
_SERVICE = re.compile(r"(?P<name>[^@]+)@(?P<type>[^@]+/srv/[^@]+)(@.+)?")
_SERVICES = ("SpawnEntity", "DeleteEntity", "SetEntityPose", "ControlWorld")
"""Types of ros_gz_interfaces' services that the simulator answers by any name."""
_DIRECTIONS = {"[": "GZ_TO_ROS", "]": "ROS_TO_GZ", "@": "BIDIRECTIONAL"}


class Bridged(NamedTuple):
    """A topic under two names, or a service.

    Attributes:
        direction: `GZ_TO_ROS`, `ROS_TO_GZ` or `BIDIRECTIONAL`; `SERVICE` of a service, whose name
            is one.
    """

    gz: str
    ros: str
    kind: str
    direction: str


def bridged(words: list[str]) -> Iterator[Bridged]:
    """Yield what a bridge's arguments and its `config_file` say.

    Of services those that the simulator answers: others are printed, as are entries that are none.

    Raises:
        Ros2Error: An argument is none, or ROS has no such name.
    """
    given = ros_arguments(words)
    space = given.remapped.get("__ns", "").rstrip("/")

    def resolved(name: str) -> str:
        name = given.remapped.get(name.lstrip("/"), name)
        return full_name(name if name.startswith("/") else f"{space}/{name}")

    for word in given.own:
        if (service := _SERVICE.fullmatch(word)) is not None:
            yield from _service(resolved(service["name"]), service["type"])
            continue
        found = _TOPIC.fullmatch(word)
        if found is None:
            raise Ros2Error(f"'{word}' is no topic; valid: /topic@package/msg/Type[gz.msgs.Type")
        topic = found["topic"]
        direction = _DIRECTIONS[found["direction"]]
        yield Bridged(absolute(topic), resolved(topic), found["type"], direction)
    parameters = given.values
    config, expands = parameters.get("config_file", ""), parameters.get("expand_gz_topic_names", "")
    for entry in (read_yaml(Path(config)) or ()) if config else ():
        names = entry if isinstance(entry, dict) else {}
        if "service_name" in names:
            name, kind = str(names["service_name"]), str(names.get("ros_type_name"))
            yield from _service(resolved(name), kind)
            continue
        topic = names.get("topic_name", "")
        ros, gz = (str(names.get(f"{side}_topic_name", topic)) for side in ("ros", "gz"))
        if not ros or not gz or not names.get("ros_type_name"):
            problem = "needs ros_topic_name, gz_topic_name (or topic_name) and ros_type_name"
            print(f"{config}: left out: the entry {entry} {problem}", flush=True)
            continue
        if expands.lower() == "true" and not gz.startswith("/"):
            gz = f"{space}/{gz}"
        direction = str(names.get("direction", "BIDIRECTIONAL"))
        yield Bridged(absolute(gz), resolved(ros), str(names["ros_type_name"]), direction)


def _service(name: str, kind: str) -> Iterator[Bridged]:
    """Yield a service that the simulator answers itself, by its type; print another."""
    if kind.removeprefix("ros_gz_interfaces/srv/") in _SERVICES:
        yield Bridged(name, name, kind, "SERVICE")
    else:
        valid = ", ".join(_SERVICES)
        print(f"{name} is not bridged: of the types, the simulator has {valid}", flush=True)


def _is_there(node: Any, name: str, direction: str) -> bool:
    gives = direction != "ROS_TO_GZ" and node.count_publishers(name)
    return bool(gives or (direction != "GZ_TO_ROS" and node.count_subscribers(name)))


def simulated(node: Any, topic: Bridged) -> Bridged | None:
    """Return a topic by the simulator's name of it; None while it is not there.

    Gazebo names topics of a robot whose file names none after its model and sensor; here they are
    the robot's own, below its namespace where there are several robots.
    """
    topic = topic._replace(gz=spelled(topic.gz))
    if POSES.fullmatch(topic.gz):  # there once somebody listens
        return topic._replace(direction="GZ_TO_ROS")
    if _CLOCK.fullmatch(topic.gz):
        topic = topic._replace(gz="/clock")
    found = _OF_GAZEBO.fullmatch(topic.gz)
    if found is None:
        return topic if _is_there(node, topic.gz, topic.direction) else _by_file(node, topic)
    last = found["topic"]
    own, is_in = _OWN.get(last, last), last == "cmd_vel"
    names = [f"{found['sensor']}/{own.rpartition('/')[2]}"] if found["sensor"] else []
    spaces = f"/{found['model']}/", "/"
    ours = (space + name for space in spaces for name in (*names, own))
    count = node.count_subscribers if is_in else node.count_publishers
    for name in (topic.gz, *ours):
        if count(name):
            return topic._replace(gz=name, direction="ROS_TO_GZ" if is_in else "GZ_TO_ROS")
    return None


def _by_file(node: Any, topic: Bridged) -> Bridged | None:
    """Return a topic of a model that was spawned by another name than its file's, as here."""
    named = _OF_MODEL.fullmatch(topic.gz)
    if named is None:
        return None
    rest = f"/model/[^/]+/{re.escape(named['topic'])}"
    others = [name for name, _ in node.get_topic_names_and_types() if name != topic.gz]
    found = (
        name
        for own in (f"/{named['model']}{rest}", rest)  # below its namespace, where it has one
        for name in others
        if re.fullmatch(own, name) and _is_there(node, name, topic.direction)
    )
    return next((topic._replace(gz=name) for name in found), None)


def marks(topics: list[Bridged]) -> list[str]:
    """Return the topics by which the simulator knows what is bridged, as `BRIDGES` says."""
    own = [BRIDGES] if topics else []
    hands_on = any(
        "TFMessage" in t.kind and t.direction != "ROS_TO_GZ" and not POSES.fullmatch(t.gz)
        for t in topics
    )
    return [*own, f"{BRIDGES}/tf"] if hands_on else own


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
    entries, relays = list(bridged(words)), list[Relay]()
    services = [entry for entry in entries if entry.direction == "SERVICE"]
    waiting = [entry for entry in entries if entry not in services]
    renamed, looks = ros_arguments(words).remapped, 0
    own = [f"{name}:={new}" for name, new in renamed.items() if name.startswith("__")]
    own = [word for one in own for word in ("-r", one)]  # topics' names are resolved already
    with Client(name="ros_gz_bridge", words=["--ros-args", *own]) as client:
        for service in services:  # the simulator has those that a client asks for
            client.node.create_client(class_of(service.kind), service.ros)
        for name in marks(waiting):
            client.node.create_publisher(class_of("std_msgs/msg/Empty"), name, qos.DEFAULT)
        client.discover()
        while True:
            found = {topic: known for topic in waiting if (known := simulated(client.node, topic))}
            waiting = [topic for topic in waiting if topic not in found]
            for topic in found.values():
                if topic.gz != topic.ros:
                    mixes = topic.direction == "GZ_TO_ROS" and "TFMessage" not in topic.kind
                    if mixes and client.node.count_publishers(topic.ros):
                        problem = f"others publish on {topic.ros} too, perhaps the simulator"
                        print(f"{problem}: give {topic.gz} a name of its own", flush=True)
                    relays.append(Relay(client.node, topic))
                    print(f"{topic.gz} is {topic.ros} too ({topic.direction})", flush=True)
            if found and not waiting and not relays:
                print("nothing to do: the simulator publishes ROS's topics itself", flush=True)
            looks += 1
            lacking = [t.gz for t in waiting if not _is_there(client.node, t.ros, t.direction)]
            if lacking and looks == 120:  # a minute of them
                print(f"not here yet: {', '.join(lacking)}", flush=True)
            for relay in relays:
                relay.look()
            client.pause(0.5)
