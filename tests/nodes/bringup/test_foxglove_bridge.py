"""Claims: a Foxglove client gets all topics byte for byte, publishes, and sees parameters."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import pytest

pytest.importorskip("foxglove", reason="no Foxglove SDK here")

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_stamped
from arjuna_core.se2 import SE2
from bringup.viewing.foxglove.bridge import Bridge, BridgeError
from tests.helpers.processes import DEADLINE
from tests.helpers.ros import RosBench


class Studio:
    """A client that speaks Foxglove's protocol, beside a robot."""

    def __init__(self, ros: RosBench, bridge: Bridge, socket: Connection) -> None:
        self.ros, self._bridge, self._socket = ros, bridge, socket
        self.texts: list[Any] = []
        self.data: list[bytes] = []

    def send(self, **message: Any) -> None:
        self._socket.send(json.dumps(message))

    def publish(self, channel: int, data: bytes) -> None:
        self._socket.send(struct.pack("<BI", 1, channel) + data)

    def until(self, done: Callable[[], Any]) -> Any:
        end = time.monotonic() + DEADLINE
        while not (found := done()):
            assert time.monotonic() < end, f"it did not happen in time; got {self.texts[-3:]}"
            self.ros.process.drain()
            self._bridge.step()
            self._receive()
        return found

    def _receive(self) -> None:
        try:
            message = self._socket.recv(timeout=0.01)
        except TimeoutError:
            return
        if isinstance(message, str):
            self.texts.append(json.loads(message))
        else:
            self.data.append(message)

    def said(self, op: str) -> list[Any]:
        return [text for text in self.texts if text["op"] == op]

    def channel(self, topic: str) -> Any:
        return self.until(
            lambda: next(
                (c for a in self.said("advertise") for c in a["channels"] if c["topic"] == topic),
                None,
            )
        )

    def subscribe(self, topic: str) -> None:
        channel = self.channel(topic)["id"]
        self.send(op="subscribe", subscriptions=[{"id": channel, "channelId": channel}])

    def payloads(self) -> list[bytes]:
        """Return what came on subscriptions, without its head: kind, subscription and time."""
        return [data[13:] for data in self.data if data[0] == 1]


@pytest.fixture
def studio() -> Iterator[Studio]:
    with ExitStack() as opened:
        ros = opened.enter_context(closing(RosBench(transport="dds")))
        bridge = opened.enter_context(closing(Bridge("127.0.0.1", 0, ros.process.context)))
        address = f"ws://127.0.0.1:{bridge.port}"
        socket = opened.enter_context(connect(address, subprotocols=["foxglove.sdk.v1"]))  # type: ignore[list-item]
        yield Studio(ros, bridge, socket)


def test_a_topic_is_advertised_with_its_definition(studio: Studio) -> None:
    studio.ros.publish(LaserScan, "/scan", LaserScan())
    channel = studio.channel("/scan")
    assert channel["encoding"] == "cdr"
    assert channel["schemaName"] == "sensor_msgs/msg/LaserScan"
    assert channel["schemaEncoding"] == "ros2msg"
    assert "float32[] ranges" in channel["schema"]
    assert "MSG: std_msgs/Header" in channel["schema"]


def test_messages_come_byte_for_byte(studio: Studio) -> None:
    message = LaserScan(header=header("lidar", 1.5), ranges=[1.0, 2.0])
    studio.ros.publish(LaserScan, "/scan", message)
    studio.subscribe("/scan")

    def came() -> list[bytes]:
        studio.ros.publish(LaserScan, "/scan", message)
        return studio.payloads()

    assert studio.until(came)[0] == serialize_message(message)


def test_what_is_latched_comes_without_being_published_again(studio: Studio) -> None:
    studio.ros.publish(String, "/robot_description", String(data="<robot/>"), qos.LATCHED)
    studio.subscribe("/robot_description")
    assert b"<robot/>" in studio.until(studio.payloads)[0]


def test_a_topic_is_subscribed_to_only_while_a_client_listens(studio: Studio) -> None:
    studio.ros.publish(LaserScan, "/scan", LaserScan())
    channel = studio.channel("/scan")["id"]
    count = studio.ros.node.count_subscribers
    assert count("/scan") == 0
    studio.subscribe("/scan")
    studio.until(lambda: count("/scan") == 1)
    studio.send(op="unsubscribe", subscriptionIds=[channel])
    studio.until(lambda: count("/scan") == 0)


def test_a_topic_that_goes_is_unadvertised(studio: Studio) -> None:
    publisher = studio.ros.node.create_publisher(String, "/brief", 1)
    studio.channel("/brief")
    studio.ros.node.destroy_publisher(publisher)
    studio.until(lambda: studio.said("unadvertise"))


def test_a_client_sends_a_goal(studio: Studio) -> None:
    goals = studio.ros.collect(PoseStamped, "/goal_pose")
    kind = "geometry_msgs/msg/PoseStamped"
    channel = {"id": 7, "topic": "/goal_pose", "encoding": "cdr", "schemaName": kind}
    studio.send(op="advertise", channels=[channel])
    studio.until(lambda: studio.ros.node.count_publishers("/goal_pose"))
    goal = pose_stamped(SE2(1.0, 2.0, 0.0), "map", 0.0)

    def came() -> list[Any]:
        studio.publish(7, serialize_message(goal))
        return goals

    assert studio.until(came)[0] == goal
    studio.send(op="unadvertise", channelIds=[7])
    studio.until(lambda: not studio.ros.node.count_publishers("/goal_pose"))


@pytest.mark.parametrize(
    ("kind", "problem"),
    [
        ("no_msgs/msg/None", "type 'no_msgs/msg/None' is not installed"),
        ("nonsense", "is no type"),
    ],
)
def test_a_client_hears_what_it_cannot_publish(kind: str, problem: str, studio: Studio) -> None:
    channel = {"id": 1, "topic": "/x", "encoding": "cdr", "schemaName": kind}
    studio.send(op="advertise", channels=[channel])
    studio.until(lambda: any(problem in s["message"] for s in studio.said("status")))


def test_parameters_are_read_and_set(studio: Studio) -> None:
    node = Node("robot", context=studio.ros.process.context)
    studio.ros.process.executor.add_node(node)
    node.declare_parameter("speed", 0.5)
    node.declare_parameter("names", ["a", "b"])
    studio.until(lambda: studio.ros.node.get_service_names_and_types())
    studio.send(op="getParameters", parameterNames=[], id="all")

    def values_of(identity: str) -> Any:
        answers = [a for a in studio.said("parameterValues") if a.get("id") == identity]
        return {p["name"]: p.get("value") for p in answers[0]["parameters"]} if answers else None

    values = studio.until(lambda: values_of("all"))
    assert values["/robot.speed"] == 0.5
    assert values["/robot.names"] == ["a", "b"]
    new = {"name": "/robot.speed", "value": 0.75, "type": "float64"}
    studio.send(op="setParameters", parameters=[new], id="new")
    assert studio.until(lambda: values_of("new")) == {"/robot.speed": 0.75}
    assert node.get_parameter("speed").value == 0.75
    node.destroy_node()


def test_an_address_of_another_machine_is_refused() -> None:
    with pytest.raises(BridgeError, match=r"'192\.0\.2\.1' port 0 cannot be served"):
        Bridge("192.0.2.1", 0)
