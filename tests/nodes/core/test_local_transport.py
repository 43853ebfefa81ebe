"""The local transport: what nodes get by it, and in which order, is what the middleware brings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.action import Wait
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.exceptions import InvalidHandle, InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from std_srvs.srv import Trigger

from arjuna_core.ros.local import topics
from arjuna_core.ros.local.transport import ChangedMessageError, TransportError
from tests.helpers.echo import EchoNode
from tests.helpers.ros import TICK, RosBench

BEST_EFFORT, RELIABLE = ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL


@pytest.fixture(params=["local", "dds"])
def either(request: pytest.FixtureRequest) -> Iterator[RosBench]:
    with closing(RosBench(transport=request.param)) as bench:
        yield bench


def _noting(received: list[str], name: str) -> Callable[[Any], None]:
    return lambda message: received.append(name + message.data)


def texts(messages: list[Any]) -> list[str]:
    return [message.data for message in messages]


def test_messages_come_in_the_order_of_publication_over_all_topics(either: RosBench) -> None:
    received: list[str] = []
    outs = {}
    for name in ("b", "a"):
        outs[name] = either.node.create_publisher(String, name, 10)
        either.node.create_subscription(String, name, _noting(received, name), 10)
    either.process.drain()
    for name, data in (("a", "1"), ("b", "2"), ("a", "3"), ("b", "4")):
        outs[name].publish(String(data=data))
    assert received == []
    either.process.drain()
    assert received == ["a1", "b2", "a3", "b4"]


def test_what_a_callback_publishes_comes_behind_what_waits(either: RosBench) -> None:
    received: list[str] = []
    out = either.node.create_publisher(String, "out", 10)

    def answer(message: Any) -> None:
        received.append(message.data)
        if len(message.data) == 1:
            out.publish(String(data=message.data + "!"))

    either.node.create_subscription(String, "out", answer, 10)
    either.process.drain()
    for data in "xyz":
        out.publish(String(data=data))
    either.process.drain()
    assert received == ["x", "y", "z", "x!", "y!", "z!"]


@pytest.mark.parametrize("depth", [1, 3])
def test_of_more_than_its_depth_a_subscription_keeps_the_last(either: RosBench, depth: int) -> None:
    received: list[Any] = []
    out = either.node.create_publisher(String, "out", QoSProfile(depth=10))
    either.node.create_subscription(String, "out", received.append, QoSProfile(depth=depth))
    either.process.drain()
    for number in range(6):
        out.publish(String(data=str(number)))
    either.process.drain()
    assert texts(received) == [str(number) for number in range(6 - depth, 6)]


def test_a_subscription_that_keeps_all_loses_nothing(bench: RosBench) -> None:
    received: list[Any] = []
    everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=1)
    out = bench.node.create_publisher(String, "out", QoSProfile(depth=1))
    bench.node.create_subscription(String, "out", received.append, everything)
    for number in range(2000):
        out.publish(String(data=str(number)))
    bench.process.drain()
    assert len(received) == 2000


def test_what_is_latched_comes_to_whoever_is_late(bench: RosBench) -> None:
    kept = QoSProfile(depth=2, durability=LATCHED)
    out = bench.node.create_publisher(String, "out", kept)
    for data in ("first", "second", "third"):
        out.publish(String(data=data))
    assert texts(bench.collect(String, "out", kept)) == ["second", "third"]
    assert texts(bench.collect(String, "out", QoSProfile(depth=2))) == []


@pytest.mark.parametrize(
    ("offer", "request_", "received"),
    [
        ((RELIABLE, VOLATILE), (RELIABLE, VOLATILE), True),
        ((RELIABLE, VOLATILE), (BEST_EFFORT, VOLATILE), True),
        ((BEST_EFFORT, VOLATILE), (RELIABLE, VOLATILE), False),
        ((RELIABLE, VOLATILE), (RELIABLE, LATCHED), False),
        ((RELIABLE, LATCHED), (RELIABLE, VOLATILE), True),
    ],
)
def test_who_asks_for_more_than_is_offered_hears_nothing(
    either: RosBench, offer: Any, request_: Any, received: bool
) -> None:
    profiles = [
        QoSProfile(depth=5, reliability=reliability, durability=durability)
        for reliability, durability in (offer, request_)
    ]
    out = either.node.create_publisher(String, "out", profiles[0])
    messages = either.collect(String, "out", profiles[1])
    out.publish(String(data="-"))
    either.process.drain()
    assert out.get_subscription_count() == len(messages) == int(received)


def test_numbers_arrive_as_the_wire_holds_them(either: RosBench) -> None:
    scans = either.collect(LaserScan, "scan")
    sent = LaserScan(angle_min=0.1, ranges=[0.1, float("inf")])
    sent.header.stamp.sec = True
    either.publish(LaserScan, "scan", sent)
    assert scans[0].angle_min == 0.10000000149011612
    assert list(scans[0].ranges) == [0.10000000149011612, float("inf")]
    assert type(scans[0].header.stamp.sec) is int


def test_a_publisher_may_use_its_message_again(either: RosBench) -> None:
    received = either.collect(Odometry, "odom")
    message = Odometry()
    for x in (1.0, 2.0):
        message.pose.pose.position.x = message.pose.covariance[0] = x
        either.publish(Odometry, "odom", message)
    assert [m.pose.pose.position.x for m in received] == [1.0, 2.0]
    assert [m.pose.covariance[0] for m in received] == [1.0, 2.0]


def test_a_reader_that_changes_a_message_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARJUNA_WATCH_MESSAGES", "1")
    with closing(RosBench()) as bench:
        bench.node.create_subscription(
            Twist, "speed", lambda message: setattr(message.linear, "x", 9.0), 10
        )
        bench.publish(Twist, "speed", Twist())
        with pytest.raises(ChangedMessageError, match="a message of '/speed' was changed"):
            bench.advance(30.0)


def test_a_message_is_judged_once_for_all(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> None:
    judged: list[Any] = []

    def problem_of(message: Any, now: float) -> str:
        judged.append(message)
        return "it is no good"

    for name in ("one", "two"):
        node = EchoNode(bench.process, name=name)
        node.trigger_configure()
        node.trigger_activate()
    monkeypatch.setattr(topics, "problem_of", problem_of)
    bench.publish(Twist, "in", Twist())
    assert len(judged) == 1
    refused = {node for node, _ in bench.process.guard.tallies}
    assert refused == {"/one", "/two"}


def test_a_destroyed_end_neither_sends_nor_hears(bench: RosBench) -> None:
    out = bench.node.create_publisher(String, "out", 10)
    received: list[Any] = []
    ear = bench.node.create_subscription(String, "out", received.append, 10)
    out.publish(String(data="never delivered"))
    bench.node.destroy_subscription(ear)
    out.publish(String(data="to nobody"))
    bench.process.drain()
    assert received == []
    assert out.get_subscription_count() == 0
    bench.node.destroy_publisher(out)
    with pytest.raises(InvalidHandle, match="the publisher of '/out' is destroyed"):
        out.publish(String())


def test_what_is_no_message_or_no_name_is_refused(bench: RosBench) -> None:
    out = bench.node.create_publisher(String, "out", 10)
    with pytest.raises(TypeError, match=r"Expected .*String.*, got .*Twist"):
        out.publish(Twist())
    with pytest.raises(InvalidTopicNameException, match="must not contain characters other"):
        bench.node.create_publisher(String, "not a name", 10)


def test_ends_of_two_types_do_not_meet(bench: RosBench) -> None:
    received = bench.collect(Twist, "out")
    bench.publish(String, "out", String(data="-"))
    assert received == []


def test_the_graph_names_the_ends_of_a_topic(bench: RosBench) -> None:
    bench.node.create_publisher(LaserScan, "/front/scan", QoSProfile(depth=3))
    bench.collect(LaserScan, "/front/scan")
    assert ("/front/scan", ["sensor_msgs/msg/LaserScan"]) in bench.node.get_topic_names_and_types()
    (info,) = bench.node.get_publishers_info_by_topic("/front/scan")
    assert (info.node_name, info.topic_type, info.qos_profile.depth) == (
        "bench_client",
        "sensor_msgs/msg/LaserScan",
        3,
    )
    assert bench.node.count_subscribers("/front/scan") == 1
    assert bench.node.count_publishers("/back/scan") == 0


def test_a_request_that_nobody_answers_stays_open(either: RosBench) -> None:
    client = either.node.create_client(Trigger, "ask")
    assert not client.service_is_ready()
    future = client.call_async(Trigger.Request())
    either.process.drain()
    assert not future.done()


def test_requests_are_answered_in_their_order(either: RosBench) -> None:
    node = EchoNode(either.process)
    node.trigger_configure()
    asked: list[int] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(len(asked))
        response.message = str(asked[-1])
        return response

    node.serve(Trigger, "ask", answer)
    client = either.node.create_client(Trigger, "ask")
    either.process.drain()
    futures = [client.call_async(Trigger.Request()) for _ in range(3)]
    assert asked == []
    either.process.drain()
    assert [future.result().message for future in futures] == ["0", "1", "2"]


def test_lifecycle_and_its_services_take_the_same_transport(either: RosBench) -> None:
    node = EchoNode(either.process)
    either.process.drain()
    change = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE))
    assert either.call(ChangeState, "echo/change_state", change).success
    assert either.call(GetState, "echo/get_state", GetState.Request()).current_state.label == (
        node.state_label
    )


def test_a_timer_fires_by_the_process_s_time(bench: RosBench) -> None:
    node, fired = EchoNode(bench.process), []
    timer = node.create_timer(5 * TICK, lambda: fired.append(round(bench.process.now / TICK)))
    bench.advance(12 * TICK)
    assert fired == [5, 10]
    timer.cancel()
    bench.advance(10 * TICK)
    timer.reset()
    bench.advance(6 * TICK)
    assert fired == [5, 10, 27]
    node.destroy_timer(timer)
    bench.advance(10 * TICK)
    assert fired == [5, 10, 27]


def test_a_coroutine_continues_when_its_future_is_done(either: RosBench) -> None:
    node = EchoNode(either.process)
    node.trigger_configure()
    node.serve(Trigger, "ask", lambda request, response: response)
    client = either.node.create_client(Trigger, "ask")
    either.process.drain()

    async def ask() -> Any:
        return await client.call_async(Trigger.Request())

    task = either.process.executor.create_task(ask)
    for _ in range(3):
        either.process.drain()
        either.process.spin_once(0.01)
    assert task.result() == Trigger.Response()


def test_nodes_and_clients_of_the_middleware_are_refused_with_the_remedy(bench: RosBench) -> None:
    other = Node("other", context=bench.process.context)
    with pytest.raises(TransportError, match=r"'other' is .* LockStep\(transport='dds'\)"):
        bench.process.executor.add_node(other)
    other.destroy_node()
    with pytest.raises(TransportError, match=r"ActionClient goes .* use action_client"):
        ActionClient(bench.node, Wait, "wait")


def test_a_node_s_publishers_are_listed_with_their_types(bench: RosBench) -> None:
    bench.node.create_publisher(String, "said", 1)
    node, own = bench.node, (bench.node.get_name(), bench.node.get_namespace())
    bench.process.drain()
    assert ("/said", ["std_msgs/msg/String"]) in node.get_publisher_names_and_types_by_node(*own)
