"""Playing publishes the messages that were recorded, with their definition."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

from nav2_msgs.action import NavigateToPose
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage, TopicInfo, TopicQos
from arjuna_core.bags.writer import BagFolder
from arjuna_core.ros import qos
from bringup.recording.message_definitions import message_definition, type_hash
from bringup.recording.playback import PlayOptions
from bringup.recording.player import Player
from bringup.recording.recorder import Recorder
from tests.helpers.ros import RosBench

BENCH = {"transport": "dds"}


def record(bench: RosBench, folder: Path) -> Bag:
    """Record a latched and a plain topic."""
    with closing(
        Recorder(bench.process.make_node("recorder", spun=False), BagFolder(folder))
    ) as recorder:
        latched = bench.node.create_publisher(String, "/once", qos.LATCHED)
        bench.publish(String, "/often", String(data="-"))
        recorder.listener.discover(lambda name, _: name in ("/once", "/often"))
        latched.publish(String(data="kept"))
        for number in range(5):
            bench.publish(String, "/often", String(data=f"message {number}"))
    return Bag(folder)


def play(bench: RosBench, bag: Bag, **options: Any) -> None:
    node = bench.process.make_node("player", spun=False)
    player = Player(node, bag.topics.values(), PlayOptions(**options))
    bench.process.drain()
    for message in bag.messages():
        player.publish(message)
        player.publish_clock(message.time)
        bench.process.drain()


def test_the_same_bytes_arrive_that_were_recorded(tmp_path: Path, bench: RosBench) -> None:
    bag = record(bench, tmp_path / "first")
    with closing(RosBench(transport="dds")) as other:
        recorder = Recorder(
            other.process.make_node("recorder", spun=False), BagFolder(tmp_path / "second")
        )
        with closing(recorder):
            player = Player(other.process.make_node("player", spun=False), bag.topics.values())
            recorder.listener.discover(lambda name, _: name in bag.topics)
            for message in bag.messages():
                player.publish(message)
            recorder.poll()
    again = Bag(tmp_path / "second")

    def content(bag: Bag) -> list[tuple[str, bytes]]:
        return [(message.topic.name, message.data) for message in bag.messages()]

    assert content(again) == content(bag)
    assert len(content(bag)) == 6
    assert again.topics["/once"].offers[0].latched


def test_static_transforms_without_a_recorded_profile_reach_tf2(bench: RosBench) -> None:
    name, kind = "/robot1/tf_static", "tf2_msgs/msg/TFMessage"
    topic = TopicInfo(name, kind)
    player = Player(bench.process.make_node("player", spun=False), [topic])
    player.publish(BagMessage(topic, 0, bytes([0, 1, 0, 0, 0, 0, 0, 0])))
    bench.process.drain()
    assert bench.latched(TFMessage, name)


def test_topics_take_new_names_and_the_clock_runs(tmp_path: Path, bench: RosBench) -> None:
    bag = record(bench, tmp_path / "bag")
    with closing(RosBench(transport="dds")) as other:
        received = other.collect(String, "/renamed")
        clock = other.collect(Clock, "/clock", qos.CLOCK)
        play(other, bag, remap={"/often": "/renamed"}, clock_hz=1.0)
        assert [message.data for message in received] == [
            f"message {number}" for number in range(5)
        ]
        stamps = [message.clock.sec * 1_000_000_000 + message.clock.nanosec for message in clock]
        assert stamps == [message.time for message in bag.messages()]


def test_what_cannot_be_played_is_noted_and_left_out(bench: RosBench) -> None:
    notes: list[str] = []
    unknown = TopicInfo("/a", "nowhere_msgs/msg/Thing")
    text = TopicInfo("/b", "std_msgs/msg/String", message_definition("std_msgs/msg/String"))
    foreign = TopicInfo("/c", "std_msgs/msg/String", encoding="json")
    node = bench.process.make_node("player", spun=False)
    player = Player(node, [unknown, text, foreign], note=notes.append)
    for topic in (unknown, text, foreign):
        player.publish(BagMessage(topic, 0, b"\0\1\0\0\1\0\0\0\0"))
    assert player.published == 1
    assert notes == [
        "/a is left out: its type nowhere_msgs/msg/Thing is not installed",
        "/c is left out: it is encoded as 'json', not as cdr",
    ]


def test_listeners_are_waited_for_where_they_acknowledge(bench: RosBench) -> None:
    notes: list[str] = []
    definition = message_definition("std_msgs/msg/String")
    topics = [
        TopicInfo(name, "std_msgs/msg/String", definition, offers=(TopicQos(reliable),))
        for name, reliable in (("/sure", True), ("/loose", False))
    ]
    bench.collect(String, "/sure")
    player = Player(bench.process.make_node("player", spun=False), topics, note=notes.append)
    player.publish(BagMessage(topics[0], 0, b"\0\1\0\0\1\0\0\0\0"))
    player.wait_for_acknowledgement(5.0)
    assert notes == ["/loose is best effort: nobody acknowledges its messages"]


FEEDBACK = "nav2_msgs/action/NavigateToPose_FeedbackMessage"


def test_a_definition_carries_every_type_it_needs_once() -> None:
    text = message_definition("nav_msgs/msg/OccupancyGrid")
    named = [line[5:] for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(named) == [
        "builtin_interfaces/Time",
        "geometry_msgs/Point",
        "geometry_msgs/Pose",
        "geometry_msgs/Quaternion",
        "nav_msgs/MapMetaData",
        "std_msgs/Header",
    ]


def test_the_feedback_of_an_action_can_be_read_by_its_definition() -> None:
    message = NavigateToPose.Impl.FeedbackMessage()
    message.feedback.distance_remaining = 3.5
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(FEEDBACK), FEEDBACK))
    read = store.deserialize_cdr(serialize_message(message), FEEDBACK)
    assert read.feedback.distance_remaining == 3.5  # type: ignore[attr-defined]
    assert type_hash(FEEDBACK).startswith("RIHS01_")
