"""Claims: a Foxglove client gets all topics byte for byte, publishes, calls services, sees
parameters as they change, the graph, meshes and the simulator's time; nonsense ends nothing."""

from __future__ import annotations

import json
import math
import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin, Subprotocol

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_stamped
from arjuna_core.se2 import SE2
from bringup.viewing.foxglove.bridge import Bridge
from bringup.viewing.foxglove.server import SUBPROTOCOLS, BridgeError
from tests.helpers.processes import DEADLINE
from tests.helpers.ros import RosBench


class Studio:
    """A client that speaks Foxglove's protocol, beside a robot."""

    def __init__(self, ros: RosBench, bridge: Bridge, client: Connection) -> None:
        self.ros, self._bridge, self.socket = ros, bridge, client
        self.texts: list[Any] = []
        self.data: list[bytes] = []

    def send(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def publish(self, channel: int, data: bytes) -> None:
        self.socket.send(struct.pack("<BI", 1, channel) + data)

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
            message = self.socket.recv(timeout=0.01)
        except TimeoutError:
            return
        if isinstance(message, str):
            self.texts.append(json.loads(message))
        else:
            self.data.append(message)

    def said(self, op: str) -> list[Any]:
        return [text for text in self.texts if text["op"] == op]

    def status(self, text: str) -> Any:
        return self.until(lambda: any(text in each["message"] for each in self.said("status")))

    def channel(self, topic: str) -> Any:
        return self.until(
            lambda: next(
                (c for a in self.said("advertise") for c in a["channels"] if c["topic"] == topic),
                None,
            )
        )

    def values(self, identity: str | None) -> Any:
        """Return the parameters of the answer to a request, or of the last change."""
        answers = [a for a in self.said("parameterValues") if a.get("id") == identity]
        return {p["name"]: p for p in answers[-1]["parameters"]} if answers else None

    def binaries(self, code: int) -> list[bytes]:
        return [data[1:] for data in self.data if data[0] == code]

    def subscribe(self, topic: str) -> None:
        channel = self.channel(topic)["id"]
        self.send(op="subscribe", subscriptions=[{"id": channel, "channelId": channel}])

    def payloads(self) -> list[bytes]:
        """Return what came on subscriptions, without its head: kind, subscription and time."""
        return [data[12:] for data in self.binaries(1)]


@pytest.fixture
def join() -> Iterator[Callable[..., Studio]]:
    """Yield what connects another client, by a subprotocol."""
    with ExitStack() as opened:
        ros = opened.enter_context(closing(RosBench(transport="dds")))
        bridge = opened.enter_context(closing(Bridge("127.0.0.1", 0, ros.process.context)))

        def connected(subprotocol: str = SUBPROTOCOLS[0]) -> Studio:
            address = f"ws://127.0.0.1:{bridge.port}"
            client = connect(address, subprotocols=[subprotocol])  # type: ignore[list-item]
            return Studio(ros, bridge, opened.enter_context(client))

        yield connected


@pytest.fixture
def studio(join: Callable[..., Studio]) -> Studio:
    return join()


@pytest.mark.parametrize("subprotocol", SUBPROTOCOLS)
def test_the_app_takes_it_for_a_robot_of_ros_2(
    subprotocol: str, join: Callable[..., Studio]
) -> None:
    studio = join(subprotocol)
    info = studio.until(lambda: studio.said("serverInfo"))[0]
    assert info["metadata"]["ROS_DISTRO"] == "jazzy"  # it publishes no goals to others
    wanted = "clientPublish parameters parametersSubscribe services connectionGraph assets"
    assert set(wanted.split()) <= set(info["capabilities"])
    assert info["supportedEncodings"] == ["cdr"]


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
    studio.status(problem)


def test_parameters_are_read_set_and_watched(studio: Studio) -> None:
    node = Node("robot", context=studio.ros.process.context)
    studio.ros.process.executor.add_node(node)
    node.declare_parameters("", [("speed", 0.5), ("names", ["a", "b"]), ("most", [1.0, math.inf])])
    studio.until(lambda: studio.ros.node.get_service_names_and_types())

    def ask(op: str, identity: str, **fields: Any) -> Any:
        studio.send(op=op, id=identity, **fields)
        return studio.until(lambda: studio.values(identity))

    found = ask("getParameters", "all", parameterNames=[])
    assert found["/robot.speed"] == {"name": "/robot.speed", "value": 0.5, "type": "float64"}
    assert found["/robot.names"] == {"name": "/robot.names", "value": ["a", "b"]}
    assert found["/robot.most"]["value"] == [1.0, None]  # JSON has no infinity
    new = {"name": "/robot.speed", "value": 2, "type": "float64"}
    found = ask("setParameters", "new", parameters=[new])
    assert found["/robot.speed"]["value"] == node.get_parameter("speed").value == 2.0
    found = ask("setParameters", "wrong", parameters=[{"name": "/robot.speed", "value": "fast"}])
    assert found["/robot.speed"]["value"] == 2.0
    studio.status("/robot.speed: Wrong parameter type")
    studio.send(op="subscribeParameterUpdates", parameterNames=["/robot.speed"])

    def changed() -> Any:
        speed = node.get_parameter("speed").value + 1.0
        node.set_parameters([Parameter("speed", value=speed), Parameter("names", value=["c"])])
        return studio.values(None)

    assert studio.until(changed).keys() == {"/robot.speed"}
    node.destroy_node()


def test_a_service_is_called(studio: Studio) -> None:
    def answer(request: Any, response: Any) -> Any:
        response.message = "done"
        return response

    server = studio.ros.node.create_service(SetBool, "/switch", answer)
    offers = studio.until(
        lambda: [s for a in studio.said("advertiseServices") for s in a["services"]]
    )
    service = next(each for each in offers if each["name"] == "/switch")
    number = service["id"]
    assert service["requestSchema"] == service["request"]["schema"]
    assert "bool data" in service["requestSchema"]
    assert "string message" in service["response"]["schema"]
    calls = [
        (number, serialize_message(SetBool.Request()), b"cdr", ""),
        (99999, b"", b"cdr", "Unknown service"),
        (number, b"x", b"cdr", "failed to deserialize"),
        (number, b"", b"json", "Unknown encoding"),
    ]
    for call, (asked, payload, encoding, _) in enumerate(calls):
        studio.socket.send(struct.pack("<BIII", 2, asked, call, len(encoding)) + encoding + payload)
    studio.until(lambda: len(studio.said("serviceCallFailure")) == 3)
    for (asked, _, _, why), failed in zip(
        calls[1:], studio.said("serviceCallFailure"), strict=True
    ):
        assert failed["serviceId"] == asked
        assert why in failed["message"]
    (data,) = studio.until(lambda: studio.binaries(3))
    assert data[:15] == struct.pack("<III", number, 0, 3) + b"cdr"
    assert deserialize_message(data[15:], SetBool.Response).message == "done"
    studio.ros.node.destroy_service(server)
    studio.until(lambda: any(number in a["serviceIds"] for a in studio.said("unadvertiseServices")))


def test_the_graph_and_its_changes_are_sent(studio: Studio) -> None:
    node = studio.ros.node
    publisher = node.create_publisher(String, "/talk", 1)
    server = node.create_service(SetBool, "/switch", lambda request, response: response)
    studio.send(op="subscribeConnectionGraph")
    own, nobody = [node.get_fully_qualified_name()], list[str]()

    def nodes(kind: str, ids: str, name: str, wanted: list[str]) -> None:
        def last() -> Any:
            updates = [each for u in studio.said("connectionGraphUpdate") for each in u[kind]]
            return next((each[ids] for each in reversed(updates) if each["name"] == name), None)

        studio.until(lambda: last() == wanted)

    nodes("publishedTopics", "publisherIds", "/talk", own)
    nodes("subscribedTopics", "subscriberIds", "/talk", nobody)
    nodes("advertisedServices", "providerIds", "/switch", own)
    node.create_subscription(String, "/talk", lambda message: None, 1)
    nodes("subscribedTopics", "subscriberIds", "/talk", own)
    node.destroy_service(server)
    node.destroy_publisher(publisher)
    nodes("publishedTopics", "publisherIds", "/talk", nobody)
    studio.until(
        lambda: any("/switch" in u["removedServices"] for u in studio.said("connectionGraphUpdate"))
    )


@pytest.mark.parametrize(
    ("uri", "problem"),
    [
        ("package://my_robot/meshes/wheel.stl", ""),
        ("package://my_robot/meshes/none.stl", "is not found"),
        ("package://my_robot/package.xml", "is not given out"),
        ("package://my_robot/../secret.png", "is not given out"),
        ("file:///etc/wheel.stl", "is not given out"),
    ],
)
def test_meshes_of_packages_are_sent(
    uri: str, problem: str, studio: Studio, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    meshes = tmp_path / "my_robot" / "meshes"
    meshes.mkdir(parents=True)
    for path in (meshes / "wheel.stl", meshes.parent / "package.xml", tmp_path / "secret.png"):
        path.write_text("content")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    studio.send(op="fetchAsset", uri=uri, requestId=7)
    (data,) = studio.until(lambda: studio.binaries(4))
    number, status, length = struct.unpack_from("<IBI", data)
    assert (number, status) == (7, bool(problem))
    assert problem in data[9 : 9 + length].decode()
    assert data[9 + length :] == (b"" if problem else b"content")


def test_time_is_the_simulators_where_there_is_one(join: Callable[..., Studio]) -> None:
    clock = Clock(clock=Time(sec=12, nanosec=500))
    now = struct.pack("<Q", 12_000_000_500)
    early = join()
    early.ros.publish(Clock, "/clock", clock)
    early.channel("/clock")
    studio = join()
    studio.subscribe("/clock")

    def came() -> Any:
        studio.ros.publish(Clock, "/clock", clock)
        return studio.binaries(1) and studio.binaries(2)

    assert studio.until(came)[0] == now
    assert studio.binaries(1)[-1][4:12] == now
    assert "time" in studio.said("serverInfo")[0]["capabilities"]


def test_nonsense_and_who_leaves_take_nothing_from_others(join: Callable[..., Studio]) -> None:
    leaving, staying = join(), join()
    talk = leaving.ros.node.create_publisher(String, "/talk", 1)
    for studio in (leaving, staying):
        studio.subscribe("/talk")
    texts = ["", "{", "[" * 5000, "7", "[]", '{"op": "what"}', '{"op": "subscribe"}', '{"op": []}']
    texts += ['{"op": "fetchAsset", "uri": "a"}', '{"op": "advertise", "channels": [{"topic": 1}]}']
    texts += ['{"op": "setParameters", "parameters": [{"name": "/a.b", "value": {}}]}']
    nonsense: list[str | bytes] = [*texts, b"", b"\x09", b"\x01", b"\x02abc", b"\xff" * 999]
    for each in nonsense:
        leaving.socket.send(each)
    leaving.until(lambda: len(leaving.said("status")) == len(nonsense))
    assert all("Invalid message: " in each["message"] for each in leaving.said("status"))
    leaving.socket.close()

    def came() -> Any:
        talk.publish(String(data="still here"))
        return staying.payloads()

    staying.until(came)


@pytest.mark.parametrize(
    ("origin", "is_taken"),
    [
        ("https://app.foxglove.dev", True),
        ("file://", True),
        ("http://localhost:8080", True),
        ("https://app.foxglove.dev.evil.example", False),
        ("http://evil.example", False),
        ("http://localhost.evil.example:8080", False),
        ("null", False),
    ],
)
def test_pages_of_other_sites_are_refused(origin: str, is_taken: bool) -> None:
    with closing(Bridge("127.0.0.1", 0)) as bridge, ExitStack() as opened:
        if not is_taken:
            opened.enter_context(pytest.raises(InvalidStatus, match="403"))
        address = f"ws://127.0.0.1:{bridge.port}"
        named = [Subprotocol(SUBPROTOCOLS[0])]
        opened.enter_context(connect(address, origin=Origin(origin), subprotocols=named))


def test_what_is_no_client_is_turned_away_without_a_word(caplog: pytest.LogCaptureFixture) -> None:
    with (
        closing(Bridge("127.0.0.1", 0)) as bridge,
        socket.create_connection(("127.0.0.1", bridge.port), DEADLINE) as other,
    ):
        other.shutdown(socket.SHUT_WR)
        assert other.recv(1) == b""
    assert not caplog.records


def test_an_address_of_another_machine_is_refused() -> None:
    with pytest.raises(BridgeError, match=r"'192\.0\.2\.1' port 0 cannot be served"):
        Bridge("192.0.2.1", 0)
