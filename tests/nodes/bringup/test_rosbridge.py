"""Claims: a client of rosbridge's protocol hears topics, publishes, calls and serves services,
sends goals and asks rosapi; nonsense is answered with why, and ends nothing."""

from __future__ import annotations

import json
import time
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import pytest
from example_interfaces.srv import AddTwoInts
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import Spin
from rclpy.action import CancelResponse
from sensor_msgs.msg import CompressedImage, LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.actions import action_server
from bringup.ros2.prefix import prefix_folder
from bringup.ros2.rosbridge.bridge import Bridge, main
from tests.helpers.processes import DEADLINE
from tests.helpers.ros import RosBench


class Page:
    """A client, beside a robot."""

    def __init__(self, ros: RosBench, bridge: Bridge, socket: Connection) -> None:
        self.ros, self.bridge, self.socket = ros, bridge, socket
        self.got: list[Any] = []

    def send(self, op: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"op": op, **fields}))

    def until(self, done: Callable[[], Any]) -> Any:
        end = time.monotonic() + DEADLINE
        while not (found := done()):
            assert time.monotonic() < end, f"it did not happen in time; got {self.got[-3:]}"
            self.ros.process.drain()
            self.bridge.step(refresh=0.1)
            try:
                self.got.append(json.loads(self.socket.recv(timeout=0.01)))
            except TimeoutError:
                continue
        return found

    def said(self, op: str, **fields: Any) -> list[Any]:
        wanted = {"op": op, **fields}
        return [each for each in self.got if wanted.items() <= each.items()]

    def answer(self, op: str, **fields: Any) -> Any:
        """Return the first answer of a kind that has these fields, once it is there."""
        return self.until(lambda: self.said(op, **fields))[0]

    def call(self, service: str, args: Any = None) -> Any:
        identity = f"call_service:{service}:{len(self.got)}"
        given = {} if args is None else {"args": args}
        self.send("call_service", id=identity, service=service, **given)
        return self.answer("service_response", id=identity, service=service)


@pytest.fixture
def page() -> Iterator[Page]:
    with ExitStack() as opened:
        ros = opened.enter_context(closing(RosBench(transport="dds")))
        bridge = opened.enter_context(closing(Bridge("127.0.0.1", 0, ros.process.context)))
        socket = opened.enter_context(connect(f"ws://127.0.0.1:{bridge.port}"))
        yield Page(ros, bridge, socket)


def test_messages_come_in_json_as_rosbridge_writes_them(page: Page) -> None:
    scan = LaserScan(ranges=[1.5, float("inf"), float("nan")], intensities=[2.0])
    page.ros.publish(LaserScan, "/scan", scan)
    page.send("subscribe", topic="scan", type="sensor_msgs/LaserScan", id="a")
    page.send("subscribe", topic="/image", type="sensor_msgs/msg/CompressedImage")

    def both() -> bool:
        page.ros.publish(LaserScan, "/scan", scan, qos.SENSOR_PUBLISHER)
        page.ros.publish(CompressedImage, "/image", CompressedImage(format="png", data=b"\0\1\2"))
        return all(page.said("publish", topic=name) for name in ("scan", "/image"))

    page.until(both)
    message = page.said("publish", topic="scan")[0]["msg"]
    assert message["ranges"] == [1.5, None, None]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    picture = page.said("publish", topic="/image")[0]["msg"]
    assert picture["data"] == b64encode(b"\0\1\2").decode()


def test_what_is_latched_comes_also_where_its_publisher_comes_later(page: Page) -> None:
    page.send("subscribe", topic="/map_name", type="std_msgs/String")
    page.until(lambda: page.ros.node.count_subscribers("/map_name"))
    page.ros.publish(String, "/map_name", String(data="room"), qos.LATCHED)
    assert page.answer("publish", topic="/map_name")["msg"] == {"data": "room"}


def test_a_topic_is_throttled_and_left(page: Page) -> None:
    page.ros.publish(String, "/chat", String(data="0"))
    page.send("subscribe", topic="/chat", throttle_rate=3600_000, id="slow")
    page.send("subscribe", topic="/chat", id="fast")

    def many() -> bool:
        page.ros.publish(String, "/chat", String(data="1"))
        return len(page.said("publish")) > 5

    page.until(many)
    page.send("unsubscribe", topic="/chat", id="fast")
    page.send("subscribe", topic="/chat", id="never", throttle_rate=0)
    page.send("unsubscribe", topic="/chat")
    page.until(lambda: page.ros.node.count_subscribers("/chat") == 0)


def test_a_first_message_waits_for_who_listens(page: Page) -> None:
    """A page's button advertises and publishes at once: the robot hears that already."""
    heard = page.ros.collect(PoseStamped, "/goal_pose")
    pose = {"position": {"x": 1, "y": 2.5}, "orientation": {"w": 1.0}}
    page.send("advertise", topic="/goal_pose", type="geometry_msgs/PoseStamped")
    page.send("publish", topic="/goal_pose", msg={"header": {"frame_id": "map"}, "pose": pose})
    page.until(lambda: heard)
    assert heard[0].header.frame_id == "map"
    assert heard[0].header.stamp.sec > 0  # of now, as rosbridge gives it
    assert (heard[0].pose.position.x, heard[0].pose.position.y) == (1.0, 2.5)
    stamp = {"secs": 7, "nsecs": 5}
    page.send("publish", topic="/goal_pose", msg={"header": {"stamp": stamp}})
    page.until(lambda: len(heard) > 1)
    assert (heard[1].header.stamp.sec, heard[1].header.stamp.nanosec) == (7, 5)
    images = page.ros.collect(CompressedImage, "/out")
    data = b64encode(b"\7\0").decode()
    page.send("publish", topic="/out", type="sensor_msgs/CompressedImage", msg={"data": data})
    page.until(lambda: images)
    assert bytes(images[0].data) == b"\7\0"
    page.send("unadvertise", topic="/goal_pose")
    page.until(lambda: page.ros.node.count_publishers("/goal_pose") == 0)


def test_services_are_called_and_what_is_wrong_is_said(page: Page) -> None:
    def switch(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = request.data, "switched"
        return response

    page.ros.node.create_service(SetBool, "/switch", switch)
    page.until(lambda: "/switch" in page.call("/rosapi/services")["values"]["services"])
    done = page.call("/switch", {"data": True})
    assert done["result"]
    assert done["values"] == {"success": True, "message": "switched"}
    assert page.call("/switch", [False])["values"]["success"] is False
    none = page.call("/none")
    assert (none["result"], none["values"]) == (False, "Service /none does not exist")
    wrong = page.call("/switch", {"dat": True})
    assert not wrong["result"]
    assert "no attribute 'dat'" in wrong["values"]


def test_a_client_serves_a_service(page: Page) -> None:
    page.send("advertise_service", service="/add", type="example_interfaces/AddTwoInts")
    client = page.ros.node.create_client(AddTwoInts, "/add")
    page.until(client.service_is_ready)
    future = client.call_async(AddTwoInts.Request(a=2, b=3))
    asked = page.answer("call_service", service="/add")
    assert asked["args"] == {"a": 2, "b": 3}
    page.send("service_response", id=asked["id"], service="/add", values={"sum": 5}, result=True)
    page.until(future.done)
    assert future.result().sum == 5
    page.send("unadvertise_service", service="/add")
    page.until(lambda: not client.service_is_ready())


@pytest.mark.parametrize("cancelled", [False, True])
def test_a_goal_is_sent_followed_and_cancelled(page: Page, cancelled: bool) -> None:
    handles: list[Any] = []

    def accepted(handle: Any) -> None:
        handle.execute()
        handle.publish_feedback(Spin.Feedback(angular_distance_traveled=0.5))
        handles.append(handle)

    callbacks = {
        "handle_accepted_callback": accepted,
        "cancel_callback": lambda _: CancelResponse.ACCEPT,
    }
    server = action_server(page.ros.node, Spin, "spin", 10.0, **callbacks)
    fields = {"action": "/spin", "id": "goal"}
    page.send("send_action_goal", action_type="nav2_msgs/Spin", feedback=True, args={}, **fields)
    told = page.answer("action_feedback", **fields)
    assert told["values"] == {"angular_distance_traveled": 0.5}
    if cancelled:
        page.send("cancel_action_goal", **fields)
        page.until(lambda: handles[0].is_cancel_requested)
    status = 5 if cancelled else 4
    server.finish(handles[0], status, Spin.Result(error_code=3))
    end = page.answer("action_result", **fields)
    assert (end["result"], end["status"]) == (True, status)
    assert end["values"]["error_code"] == 3


def test_a_goal_of_no_action_fails(page: Page) -> None:
    page.send("send_action_goal", action="/none", action_type="nav2_msgs/action/Spin", id="g")
    end = page.answer("action_result", id="g")
    assert (end["result"], end["values"]) == (False, "Action /none does not exist")
    page.send("send_action_goal", action="/none", action_type="nav2_msgs/Spn", id="h")
    assert page.answer("action_result", id="h")["result"] is False


def test_rosapi_is_answered(page: Page) -> None:
    page.ros.node.declare_parameter("speed", 0.5)
    page.ros.publish(String, "/chat", String())

    def ask(what: str, **args: Any) -> Any:
        return page.call(f"/rosapi/{what}", args)["values"]

    found = page.until(lambda: (t := ask("topics")) and "/chat" in t["topics"] and t)
    assert found["types"][found["topics"].index("/chat")] == "std_msgs/msg/String"
    raw = ask("topics_and_raw_types")
    assert "string data" in raw["typedefs_full_text"][raw["topics"].index("/chat")]
    assert ask("topic_type", topic="chat") == {"type": "std_msgs/msg/String"}
    assert "/chat" in ask("topics_for_type", type="std_msgs/msg/String")["topics"]
    assert "/bench_client" in ask("nodes")["nodes"]
    assert "/chat" in ask("node_details", node="/bench_client")["publishing"]
    assert ask("publishers", topic="/chat") == {"publishers": ["/bench_client"]}
    assert ask("get_ros_version") == {"version": 2, "distro": "jazzy"}
    name = "/bench_client:speed"
    page.until(lambda: ask("get_param", name=name) == {"value": "0.5"})
    assert ask("set_param", name=name, value="0.75") == {"successful": True}
    assert ask("get_param", name=name) == {"value": "0.75"}
    assert ask("get_param", name="/bench_client:none", default_value="7") == {"value": "7"}
    assert "valid: /NODE:NAME" in ask("get_param", name="speed")
    assert "Service /rosapi/none does not exist; valid: " in ask("none")


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        ("nonsense", "JSONDecodeError"),
        ("[]", "AttributeError"),
        ('{"op": "leap"}', "Unknown operation: leap; valid: advertise"),
        ('{"op": "subscribe", "topic": "/none"}', "Cannot infer topic type for topic /none"),
        ('{"op": "publish", "topic": "/a b", "type": "std_msgs/String"}', "a b"),
        ('{"op": "advertise", "topic": "/a", "type": "std_msgs/Strng"}', "type is invalid"),
        ('{"op": "service_response", "id": "x"}', "KeyError"),
    ],
)
def test_nonsense_is_answered_and_ends_nothing(page: Page, message: str, problem: str) -> None:
    page.socket.send(message)
    said = page.answer("status", level="error")
    assert problem in said["msg"]
    assert page.call("/rosapi/get_ros_version")["result"]


def test_pages_of_other_sites_are_refused_with_what_to_do(
    page: Page, capfd: pytest.CaptureFixture[str]
) -> None:
    address = f"ws://127.0.0.1:{page.bridge.port}"
    for origin in ("null", "https://example.org"):
        with pytest.raises(InvalidStatus, match="403"):
            connect(address, origin=Origin(origin)).close()
        assert f"a page of origin '{origin}' is refused" in capfd.readouterr().err
    connect(address, origin=Origin("http://localhost:8000")).close()


def test_what_a_client_had_goes_with_it(page: Page) -> None:
    page.send("subscribe", topic="/chat", type="std_msgs/String")
    page.send("advertise", topic="/said", type="std_msgs/String")
    page.send("advertise_service", service="/add", type="example_interfaces/AddTwoInts")
    node = page.ros.node
    client = node.create_client(AddTwoInts, "/add")
    page.until(lambda: node.count_subscribers("/chat") and client.service_is_ready())
    future = client.call_async(AddTwoInts.Request())
    page.answer("call_service", service="/add")
    page.socket.close()
    end = time.monotonic() + DEADLINE
    while node.count_subscribers("/chat") or node.count_publishers("/said") or not future.done():
        assert time.monotonic() < end, "it is still there"
        page.bridge.step(refresh=0.1)
        page.ros.process.drain()
    assert future.result().sum == 0


def test_its_launch_file_starts_it() -> None:
    file = prefix_folder() / "share/rosbridge_server/launch/rosbridge_websocket_launch.xml"
    text = file.read_text(encoding="utf-8")
    assert 'pkg="rosbridge_server" exec="rosbridge_websocket"' in text
    assert 'default="9090"' in text


@pytest.mark.parametrize(
    ("port", "problem"),
    [("one", "port: 'one' is none; valid: 0 to 65535"), ("99999", "port 99999 cannot be served")],
)
def test_a_port_that_is_none_is_told(port: str, problem: str) -> None:
    with pytest.raises(ArjunaError, match=problem):
        main(["--ros-args", "-p", f"port:={port}"])
