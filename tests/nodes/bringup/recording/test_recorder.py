"""Claims: what arrives is written byte for byte, as rosbag2 needs it; what is lost is counted."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from arjuna_core.bags.file_writer import RecordingError
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicQos
from arjuna_core.bags.writer import BagFolder
from arjuna_core.ros import qos
from bringup.recording.message_definitions import type_hash
from bringup.recording.recorder import Recorder, RecordOptions, demo_recorder
from tests.helpers.ros import RosBench


@pytest.fixture
def recording(tmp_path: Path, bench: RosBench) -> Path:
    path = tmp_path / "run.mcap"
    with closing(demo_recorder(bench.process, path)) as recorder:
        for speed in (0.5, 1.5):
            bench.advance(0.1)
            message = Twist()
            message.linear.x = speed
            bench.publish(Twist, "/cmd_vel", message)
            recorder.poll()
        bench.publish(OccupancyGrid, "/map", OccupancyGrid(), qos.LATCHED)
    return path


def test_messages_are_stamped_with_simulated_time_and_unchanged(recording: Path) -> None:
    messages = list(Bag(recording).messages())
    assert [(each.topic.name, each.time) for each in messages] == [
        ("/cmd_vel", 100_000_000),
        ("/cmd_vel", 200_000_000),
        ("/map", 200_000_000),
    ]
    assert [deserialize_message(each.data, Twist).linear.x for each in messages[:2]] == [0.5, 1.5]


def test_latched_topics_stay_latched(recording: Path) -> None:
    topic = Bag(recording).topics["/map"]
    assert topic.offers == (TopicQos(reliable=True, latched=True, depth=1),)
    assert topic.type_hash == type_hash("nav_msgs/msg/OccupancyGrid")
    assert topic.type_name == "nav_msgs/msg/OccupancyGrid"


def test_an_existing_recording_is_never_overwritten(recording: Path, bench: RosBench) -> None:
    before = recording.read_bytes()
    with pytest.raises(RecordingError, match="exists already and is not overwritten"):
        demo_recorder(bench.process, recording)
    assert recording.read_bytes() == before


def record(bench: RosBench, folder: Path) -> Recorder:
    return Recorder(bench.process.make_node("recorder", spun=False), BagFolder(folder))


def test_later_topics_are_found_and_hidden_ones_left(tmp_path: Path, bench: RosBench) -> None:
    with closing(record(bench, tmp_path / "bag")) as recorder:
        recorder.listener.discover(lambda name, _: name.startswith("/late"))
        bench.publish(String, "/late", String(data="unheard"))
        recorder.listener.discover(lambda name, _: name.startswith("/late"))
        bench.publish(String, "/late", String(data="heard"))
        bench.publish(String, "/other", String(data="not chosen"))
    (message,) = Bag(tmp_path / "bag").messages()
    assert deserialize_message(message.data, String).data == "heard"


@pytest.mark.parametrize(
    ("rosbag2", "expected"),
    [
        (False, ["listens to 4 topics", "listens to /many4, /many5"]),
        (
            True,
            [
                *(f"Subscribed to topic '/many{number}'" for number in range(6)),
                "All requested topics are subscribed. Stopping discovery...",
            ],
        ),
    ],
    ids=["many topics are one line and few are named", "rosbag2's sentences, the last one once"],
)
def test_topics_found_are_noted(
    tmp_path: Path, bench: RosBench, rosbag2: bool, expected: list[str]
) -> None:
    notes: list[str] = []
    node = bench.process.make_node("recorder", spun=False)
    names = tuple(f"/many{number}" for number in range(6))
    options = RecordOptions(lambda name, _: name in names, controlled=rosbag2, requested=names)
    bag = BagFolder(tmp_path / "bag")
    with closing(Recorder(node, bag, notes.append, options=options)) as recorder:
        for count in (4, 6):
            for name in names[:count]:
                bench.publish(String, name, String())
            recorder.discover()
        recorder.discover()
    assert notes == expected


def test_a_subscription_yields_to_a_weaker_publisher(tmp_path: Path, bench: RosBench) -> None:
    weak = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    with closing(record(bench, tmp_path / "bag")) as recorder:
        bench.publish(String, "/mixed", String(data="one"))
        recorder.listener.discover(lambda name, _: name == "/mixed")
        late = bench.node.create_publisher(String, "/mixed", weak)
        recorder.listener.discover(lambda name, _: name == "/mixed")
        late.publish(String(data="two"))
        recorder.poll()
        assert recorder.messages == 1


def test_messages_that_never_arrived_are_counted(tmp_path: Path, bench: RosBench) -> None:
    with closing(record(bench, tmp_path / "bag")) as recorder:
        bench.publish(String, "/fast", String(data="0"))
        recorder.listener.discover(lambda name, _: name == "/fast")
        for number in range(1, 1501):  # the queue holds 1000
            bench.publish(String, "/fast", String(data=str(number)))
            if number == 100:
                recorder.poll()
        recorder.poll()
        assert recorder.messages == 1100
        assert recorder.listener.lost == {"/fast": 400}
    assert Bag(tmp_path / "bag").lost == {"/fast": 400}


def test_an_unknown_type_is_noted_once_and_left_out(tmp_path: Path, bench: RosBench) -> None:
    notes: list[str] = []
    recorder = Recorder(
        bench.process.make_node("recorder", spun=False), BagFolder(tmp_path / "bag"), notes.append
    )
    with closing(recorder):
        assert not recorder.listener.listen("/x", "nowhere_msgs/msg/Thing", ())
    assert notes == ["/x is left out: its type nowhere_msgs/msg/Thing is not installed"]
