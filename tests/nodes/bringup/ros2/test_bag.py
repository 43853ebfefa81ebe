"""Claims: eighty calls of `ros2 bag` do what rosbag2 0.26 says of them, read by others' readers.

What rosbag2 says is its `--help`, its README and its sources of that release, in our words.
"""

from __future__ import annotations

import shutil
import sqlite3
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from example_interfaces.srv import AddTwoInts
from mcap.reader import make_reader
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rosbag2_interfaces import srv
from rosbag2_interfaces.msg import ReadSplitEvent, WriteSplitEvent
from rosbags import rosbag2
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo, TopicQos
from arjuna_core.bags.writer import BagFolder, SplitLimits
from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from bringup.recording import play as playing
from bringup.recording import record as recording
from bringup.recording.message_definitions import message_definition, type_hash
from bringup.recording.play import Playing
from bringup.recording.recorder import Recorder
from bringup.ros2.grammar import build_parser
from bringup.ros2.main import main
from bringup.ros2.verbs import bag as verbs
from bringup.terminal import DOWN, RIGHT, UP
from tests.helpers.ros import RosBench

SECOND = 1_000_000_000
EVENT = AddTwoInts.Event
INT, TEXT = "std_msgs/msg/Int32", "std_msgs/msg/String"
ADDED = "example_interfaces/srv/AddTwoInts_Event"
START = 100 * SECOND
PUBLISHED: dict[str, Any] = {
    "/scan": Int32,
    "/scan_filtered": Int32,
    "/imu/data": String,
    "/drive/_action/status": Int32,
    "/add/_service_event": EVENT,
    "/sum/_service_event": EVENT,
}
TOPICS = {"/scan", "/scan_filtered", "/imu/data"}
SERVICES = {"/add/_service_event", "/sum/_service_event"}


@pytest.fixture(scope="module")
def shared() -> Iterator[SimpleNamespace]:
    """A robot's node: topics, the events of two services, and a topic without a publisher."""
    bench = RosBench()
    publishers = {
        name: bench.node.create_publisher(kind, name, qos.TF) for name, kind in PUBLISHED.items()
    }
    bench.node.create_subscription(Int32, "/scan", lambda message: None, qos.TF)
    bench.node.create_subscription(Int32, "/wanted", lambda message: None, qos.TF)
    yield SimpleNamespace(bench=bench, publishers=publishers)
    bench.close()


def parsed(words: str, **paths: Path) -> Any:
    """Return the arguments of words after `ros2 bag`, with paths for the names in braces."""
    given = [word.format(**paths) for word in words.split()]
    return build_parser().parse_args(["bag", *given])


def counts(folder: Path) -> dict[str, int]:
    """Return the number of messages of each topic, by rosbags' reader, which reads every one."""
    with rosbag2.Reader(folder) as reader:
        found = dict.fromkeys((each.topic for each in reader.connections), 0)
        for connection, _, _ in reader.messages():
            found[connection.topic] += 1
    return found


def metadata(folder: Path) -> dict[str, Any]:
    content = yaml.safe_load((folder / "metadata.yaml").read_text())
    information: dict[str, Any] = content["rosbag2_bagfile_information"]
    return information


def ints(folder: Path) -> list[tuple[float, int]]:
    """Return time [s] and value of each message of /scan."""
    with rosbag2.Reader(folder) as reader:
        chosen = [each for each in reader.connections if each.topic == "/scan"]
        return [
            (stamp / SECOND, deserialize_message(data, Int32).data)
            for _, stamp, data in reader.messages(chosen)
        ]


class Run:
    """A recorder at work, and the robot beside it."""

    def __init__(self, words: str, shared: SimpleNamespace, folder: Path, config: Path) -> None:
        given = parsed(words, bag=folder, file=config)
        self.bench, self.publishers = shared.bench, shared.publishers
        self.options = verbs.record_options(given)
        self.bag = verbs.folder_of(given)
        self.folder = folder
        self.node = self.bench.process.make_node(given.node_name, spun=False)
        self.recorder = Recorder(self.node, self.bag, options=self.options)
        self.controls = recording.control(self.recorder, self.node, self.bag, self.options)
        self.recorder.discover()

    def publish(self, *values: int) -> None:
        """Publish a message of each topic for each value, and take it."""
        for value in values:
            for name, kind in PUBLISHED.items():
                message = kind()
                if kind is not EVENT:
                    message.data = value if kind is Int32 else "x" * 1000
                self.publishers[name].publish(message)
            self.recorder.poll()

    def call(self, kind: Any, name: str) -> Any:
        return self.bench.call(kind, f"/{self.options.node_name}/{name}", kind.Request())


@dataclass(frozen=True)
class Record:
    """A call of `record`, what rosbag2 says of it, and what must be so then.

    Attributes:
        during: What happens while it records; three messages of each topic by default.
        file: The content of a file that it names.
    """

    words: str
    promise: str
    holds: Callable[[Path], bool]
    during: Callable[[Run], None] = lambda run: run.publish(1, 2, 3)
    file: str = ""


def takes(*names: str) -> Callable[[Path], bool]:
    """Return whether a recording has three messages of these topics and no other topic."""
    return lambda folder: counts(folder) == dict.fromkeys(names, 3)


def pause(run: Run) -> None:
    run.publish(1)
    run.call(srv.Pause, "pause")
    assert run.call(srv.IsPaused, "is_paused").paused
    run.publish(2)
    run.call(srv.Resume, "resume")
    assert not run.call(srv.IsPaused, "is_paused").paused
    run.publish(3)


def start_paused(run: Run) -> None:
    run.publish(1, 2)
    run.call(srv.Resume, "resume")
    run.publish(3)


def split(run: Run) -> None:
    events = run.bench.collect(WriteSplitEvent, "/events/write_split")
    run.publish(1, 2)
    run.call(srv.SplitBagfile, "split_bagfile")
    run.publish(3)
    run.bench.process.drain()
    (event,) = events
    files = [run.folder / f"bag_{number}.mcap" for number in (0, 1)]
    assert [event.closed_file, event.opened_file] == list(map(str, files))
    assert event.node_name == "/rosbag2_recorder"


def snapshot(run: Run) -> None:
    run.publish(*range(1, 10))
    assert run.call(srv.Snapshot, "snapshot").success
    run.publish(10)


def no_snapshot_service(run: Run) -> None:
    services = dict(run.bench.node.get_service_names_and_types())
    assert "/taper/pause" in services
    assert "/taper/snapshot" not in services
    run.publish(1, 2, 3)


def with_clock(run: Run) -> None:
    run.publish(1)
    for value in (2, 3):
        run.bench.advance(0.02)
        run.publish(value)


def each_while(run: Run) -> None:
    for value in range(4):
        run.bench.advance(0.6)
        run.publish(value)


def later_topic(run: Run) -> None:
    run.publish(1, 2, 3)
    late = run.bench.node.create_publisher(Int32, "/late", qos.TF)
    if run.options.discovery:
        assert run.options.polling_period == 0.05
        run.recorder.discover()
    late.publish(Int32(data=1))
    run.recorder.poll()
    run.bench.node.destroy_publisher(late)


def best_effort(run: Run) -> None:
    run.publish(1)
    weak = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    other = run.bench.node.create_publisher(Int32, "/scan", weak)
    other.publish(Int32(data=2))
    run.recorder.poll()
    run.bench.node.destroy_publisher(other)


def written_at_once(run: Run) -> None:
    assert run.options.cache == 0
    run.publish(1, 2, 3)


def mcap_chunks(folder: Path) -> list[Any]:
    with next(folder.glob("*.mcap")).open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return list(summary.chunk_indexes)


def rows(folder: Path, sql: str) -> list[Any]:
    with closing(sqlite3.connect(next(folder.glob("*.db3")))) as database:
        return database.execute(sql).fetchall()


def packed(folder: Path) -> set[str]:
    """Return the kinds of files in a recording."""
    return {"".join(file.suffixes) for file in folder.iterdir()}


RECORD = [
    Record("-o {bag} /scan /imu/data", "topics by place", takes("/scan", "/imu/data")),
    Record("-o {bag} --topics /scan", "only these topics", takes("/scan")),
    Record("-o {bag} --topics scan", "a relative name is completed", takes("/scan")),
    Record(
        "-o {bag} --all-topics",
        "all topics but hidden ones",
        lambda folder: (
            counts(folder).keys() >= TOPICS
            and not counts(folder).keys() & SERVICES
            and "/drive/_action/status" not in counts(folder)
        ),
    ),
    Record(
        "-o {bag} -a",
        "all topics and services but hidden ones",
        lambda folder: (
            counts(folder).keys() >= TOPICS | SERVICES
            and "/drive/_action/status" not in counts(folder)
        ),
    ),
    Record("-o {bag} --all-services", "services' events alone", takes(*SERVICES)),
    Record("-o {bag} --services /add", "one service's", takes("/add/_service_event")),
    Record(
        *("-o {bag} -e scan", "an expression is found anywhere in a name"),
        takes("/scan", "/scan_filtered"),
    ),
    Record(
        *("-o {bag} --regex an$|um$", "in services' names too"),
        takes("/scan", "/sum/_service_event"),
    ),
    Record(
        *("-o {bag} -e scan|imu --exclude-regex filt|data$", "works on top of --regex"),
        takes("/scan"),
    ),
    Record(
        *("-o {bag} -e scan --exclude-topics /scan_filtered", "works on top of --regex"),
        takes("/scan"),
    ),
    Record(
        *("-o {bag} -e ^/(scan|imu) --exclude-topic-types std_msgs/msg/String", "not of the type"),
        takes("/scan", "/scan_filtered"),
    ),
    Record(
        *("-o {bag} --topic-types std_msgs/msg/String", "of these types"),
        lambda folder: counts(folder) == {"/imu/data": 3},
    ),
    Record(
        *("-o {bag} --all-services --exclude-services /add", "not these services"),
        takes("/sum/_service_event"),
    ),
    Record(
        *("-o {bag} -e drive --include-hidden-topics", "hidden topics as well"),
        takes("/drive/_action/status"),
    ),
    Record(
        *("-o {bag} --topics /scan /wanted --include-unpublished-topics", "without publishers too"),
        lambda folder: counts(folder) == {"/scan": 3, "/wanted": 0},
    ),
    Record(
        *("-o {bag} -e scan --ignore-leaf-topics", "not topics without a subscription"),
        takes("/scan"),
    ),
    Record(
        *("-o {bag} --topics /scan /late --no-discovery", "only what is there at the start"),
        *(takes("/scan"), later_topic),
    ),
    Record(
        *("-o {bag} --topics /scan /late -p 50", "what appears later is found"),
        lambda folder: counts(folder) == {"/scan": 3, "/late": 1},
        later_topic,
    ),
    Record(
        *("-o {bag} --topics /scan -s sqlite3", "sqlite3 of the fourth schema"),
        lambda folder: (
            rows(folder, "SELECT schema_version FROM schema") == [(4,)]
            and rows(
                folder,
                "SELECT count(*) FROM messages JOIN topics ON topic_id = topics.id"
                f" WHERE name = '/scan' AND type = '{INT}'",
            )
            == [(3,)]
            and metadata(folder)["storage_identifier"] == "sqlite3"
            and takes("/scan")(folder)
        ),
    ),
    Record(
        *("-o {bag} --topics /scan -s sqlite3 --storage-preset-profile resilient", "no loss"),
        lambda folder: rows(folder, "PRAGMA journal_mode") == [("wal",)],
    ),
    Record(
        *("-o {bag} --topics /imu/data --storage-preset-profile fastwrite", "no chunks"),
        lambda folder: mcap_chunks(folder) == [],
    ),
    Record(
        *("-o {bag} --topics /imu/data --storage-config-file {file}", "the writer's settings"),
        lambda folder: (
            {each.compression for each in mcap_chunks(folder)} == {"lz4"}
            and len(mcap_chunks(folder)) == 3
        ),
        file="compression: Lz4\nchunkSize: 1000\n",
    ),
    Record(
        *(
            "-o {bag} --topics /imu/data --compression-mode file --compression-format zstd",
            "each file compressed",
        ),
        lambda folder: (
            packed(folder) == {".mcap.zstd", ".yaml"}
            and takes("/imu/data")(folder)
            and metadata(folder)["compression_mode"] == "FILE"
        ),
    ),
    Record(
        *(
            "-o {bag} --topics /imu/data --compression-mode message -s sqlite3",
            "each message compressed",
        ),
        lambda folder: (
            rows(folder, "SELECT max(length(data)) < 100 FROM messages") == [(1,)]
            and takes("/imu/data")(folder)
            and metadata(folder)["compression_format"] == "zstd"
        ),
    ),
    Record(
        *(
            "-o {bag} --topics /imu/data -b 2000 --compression-mode file --compression-threads 2",
            "split by size, compressed in parallel",
        ),
        lambda folder: (
            len(list(folder.glob("*.zstd"))) > 1
            and sum(each["message_count"] for each in metadata(folder)["files"]) == 20
            and counts(folder) == {"/imu/data": 20}
        ),
        lambda run: run.publish(*range(20)),
    ),
    Record(
        *("-o {bag} --topics /scan -b 1000000 -d 1 --use-sim-time", "whichever comes first splits"),
        lambda folder: (
            [each["message_count"] for each in metadata(folder)["files"]] == [2, 2]
            and metadata(folder)["relative_file_paths"] == ["bag_0.mcap", "bag_1.mcap"]
        ),
        each_while,
    ),
    Record(
        *("-o {bag} --topics /scan --use-sim-time", "stamps of /clock, nothing before the first"),
        lambda folder: (
            [value for _, value in ints(folder)] == [2, 3]
            and round(ints(folder)[1][0] - ints(folder)[0][0], 3) == 0.02
        ),
        with_clock,
    ),
    Record(
        *("-o {bag} --topics /scan --snapshot-mode --max-cache-size 40", "what the buffer holds"),
        lambda folder: [value for _, value in ints(folder)] == [5, 6, 7, 8, 9],
        snapshot,
    ),
    Record(
        *("-o {bag} --topics /scan --max-cache-size 0", "written directly"),
        *(takes("/scan"), written_at_once),
    ),
    Record(
        *("-o {bag} --topics /scan --start-paused", "begins paused, services resume"),
        lambda folder: [value for _, value in ints(folder)] == [3],
        start_paused,
    ),
    Record(
        *(
            "-o {bag} --topics /scan --disable-keyboard-controls",
            "what comes in a pause is dropped",
        ),
        lambda folder: [value for _, value in ints(folder)] == [1, 3],
        pause,
    ),
    Record(
        *("-o {bag} --topics /scan --log-level warn", "a service splits, an event says so"),
        lambda folder: [each["message_count"] for each in metadata(folder)["files"]] == [2, 1],
        split,
    ),
    Record(
        *("-o {bag} --topics /scan --node-name taper", "the node's name, no snapshots unasked"),
        *(takes("/scan"), no_snapshot_service),
    ),
    Record(
        *("-o {bag} --topics /scan --custom-data site=lab run=7 run=8", "kept, the last counts"),
        lambda folder: metadata(folder)["custom_data"] == {"site": "lab", "run": "8"},
    ),
    Record(
        *("-o {bag} --topics /scan --qos-profile-overrides-path {file}", "profiles are the file's"),
        lambda folder: [value for _, value in ints(folder)] == [1, 2],
        best_effort,
        "/scan: {reliability: best_effort, durability: volatile, history: keep_last, depth: 5}\n",
    ),
]


@pytest.mark.parametrize("row", RECORD, ids=lambda row: f"{row.words}: {row.promise}")
def test_record(row: Record, shared: SimpleNamespace, tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(row.file)
    folder = tmp_path / "bag"
    run = Run(f"record {row.words}", shared, folder, config)
    with closing(run.recorder):
        row.during(run)
    assert row.holds(folder)
    assert Bag(folder).problems == []


@pytest.fixture(scope="module")
def played_bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Two recordings, of which the first continues in a second file after 2 s."""
    folder = tmp_path_factory.mktemp("played")

    def topic(name: str, kind: str) -> TopicInfo:
        offers = (TopicQos(depth=10),)
        return TopicInfo(name, kind, message_definition(kind), type_hash(kind), offers)

    event = EVENT()
    event.info.event_type = 1  # as the service received it
    event.request = [AddTwoInts.Request(a=2, b=3)]
    with closing(BagFolder(folder / "one", SplitLimits(duration=2.0))) as one:
        for number in range(4):
            stamp = START + number * SECOND
            for name, half in (("/scan", 0), ("/scan_filtered", SECOND // 2)):
                data = serialize_message(Int32(data=number))
                one.write(topic(name, INT), stamp + half, data, stamp)
        clock = serialize_message(Clock())
        one.write(topic("/clock", "rosgraph_msgs/msg/Clock"), stamp, clock, stamp)
        one.write(topic("/add/_service_event", ADDED), stamp, serialize_message(event), stamp)
    with closing(BagFolder(folder / "two")) as two:
        data = serialize_message(String(data="between"))
        two.write(topic("/imu/data", TEXT), START + SECOND // 4, data, START)
    return {"one": folder / "one", "two": folder / "two"}


@dataclass
class Received:
    """The messages that a player published: the wall time [s], topic and value of each message.

    Attributes:
        clock: The stamps on /clock [s].
        asked: The sums that were asked of the service.
        notes: The lines that were printed.
    """

    messages: list[tuple[float, str, Any]] = field(default_factory=list)
    clock: list[float] = field(default_factory=list)
    asked: list[int] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    splits: list[str] = field(default_factory=list)

    @property
    def topics(self) -> Counter[str]:
        """Return the number of messages of each topic."""
        return Counter(name for _, name, _ in self.messages)

    @property
    def scans(self) -> list[tuple[float, int]]:
        """Wall time and value of each message of /scan."""
        return [(time, value) for time, name, value in self.messages if name == "/scan"]


class Stage:
    """A player whose time is the test's, and who listens."""

    def __init__(self, bench: RosBench, given: Any) -> None:
        self.bench, self.received, self.wall = bench, Received(), 0.0
        if given.run.endswith("burst"):
            bags, options = [Bag(Path(given.bag_path))], verbs.burst_options(given)
        else:
            bags = verbs.bags_of(given)
            options = verbs.until(verbs.play_options(given), bags, given)
        listener = bench.process.make_node("listener")
        for name, kind in (*PUBLISHED.items(), ("/front", Int32)):
            listener.create_subscription(kind, name, self.listens(name), qos.TF)
        listener.create_subscription(
            Clock, "/clock", lambda message: self.received.clock.append(stamp(message)), qos.CLOCK
        )
        listener.create_subscription(
            ReadSplitEvent,
            "/events/read_split",
            lambda message: self.received.splits.append(Path(message.opened_file).name),
            1,
        )
        listener.create_service(AddTwoInts, "/add", self._add)
        node = bench.process.make_node(options.node_name, spun=False)
        self.playing = Playing(bags, node, options, self.received.notes.append)
        self.controls = playing.control(self.playing, node)
        self._nodes = (listener, node)

    def listens(self, name: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            self.received.messages.append(
                (round(self.wall, 3), name, getattr(message, "data", None))
            )

        return take

    def _add(self, request: Any, response: Any) -> Any:
        self.received.asked.append(request.a + request.b)
        return response

    def run(self, seconds: float = 6.0) -> None:
        """Play for a time, or until all is played."""
        for _ in range(round(10 * seconds)):
            if self.playing.done:
                return
            self.playing.step(self.wall)
            self.bench.process.drain()
            self.wall += 0.1

    def call(self, kind: Any, name: str, **request: Any) -> Any:
        return self.bench.call(kind, f"/rosbag2_player/{name}", kind.Request(**request))

    def close(self) -> None:
        for node in self._nodes:
            node.destroy_node()


def stamp(message: Any) -> float:
    return float(message.clock.sec + message.clock.nanosec / SECOND)


@dataclass(frozen=True)
class Play:
    """A call of `play` or `burst`, what rosbag2 says of it, and what must be so then."""

    words: str
    promise: str
    holds: Callable[[Received], bool]
    during: Callable[[Stage], None] = lambda stage: stage.run()
    refused: str = ""


def hears(**expected: int) -> Callable[[Received], bool]:
    """Return whether these topics were received so often, and no other."""
    return lambda received: received.topics == {f"/{name}": n for name, n in expected.items()}


def by_services(stage: Stage) -> None:
    stage.run(1.2)
    stage.call(srv.Pause, "pause")
    assert stage.call(srv.IsPaused, "is_paused").paused
    stage.run(3.0)
    assert len(stage.received.scans) == 2
    assert stage.call(srv.PlayNext, "play_next").success
    assert stage.call(srv.Burst, "burst", num_messages=2).actually_burst == 2
    back = srv.Seek.Request().time
    back.sec = 101
    assert stage.call(srv.Seek, "seek", time=back).success
    assert stage.call(srv.SetRate, "set_rate", rate=2.0).success
    assert not stage.call(srv.SetRate, "set_rate", rate=-1.0).success
    assert stage.call(srv.GetRate, "get_rate").rate == 2.0
    stage.call(srv.TogglePaused, "toggle_paused")
    assert not stage.call(srv.Play, "play").success  # it plays already
    stage.run()


def stopped(stage: Stage) -> None:
    stage.run(1.2)
    stage.call(srv.Stop, "stop")
    stage.run()


def by_keys(stage: Stage) -> None:
    stage.run(0.2)
    stage.playing.press(RIGHT)
    stage.playing.press(UP)
    stage.playing.press(UP)
    stage.playing.press(DOWN)
    assert round(stage.playing.playback.rate, 3) == 1.089  # 10 % of it, as rosbag2
    stage.playing.press(" ")
    stage.run()


def bursts(stage: Stage) -> None:
    stage.playing.burst(stage.playing.options.burst or 0)
    stage.run()
    assert not stage.playing.done  # it stands still


def resumed_at_end(stage: Stage) -> None:
    stage.run()
    assert not stage.received.messages
    stage.call(srv.Resume, "resume")
    stage.run()


ONE = "/scan", "/scan_filtered"
PLAY = [
    Play(
        *("{one}", "the messages at their recorded times, services' events as topics"),
        lambda received: (
            [time for time, _ in received.scans] == [0.0, 1.0, 2.0, 3.0]
            and received.topics["/add/_service_event"] == 1
            and received.splits == ["one_1.mcap"]
        ),
    ),
    Play(
        "{one} -r 2",
        "twice as fast",
        lambda received: [t for t, _ in received.scans] == [0, 0.5, 1, 1.5],
    ),
    Play(
        "{one} --topics /scan --services /add",
        "only these topics and services",
        lambda received: set(received.topics) == {"/scan", "/add/_service_event"},
    ),
    Play("{one} -e /scan.*", "names that the expression matches", hears(scan=4, scan_filtered=4)),
    Play(
        *("{one} -e scan", "it matches whole names"),
        lambda received: not received.messages,
        refused="nothing is left to play; the recording's topics: /add",
    ),
    Play("{one} -x /scan_.* --exclude-services /add", "not these", hears(scan=4)),
    Play(
        *("{one} --exclude-topics /scan --exclude-services /add", "not these"),
        hears(scan_filtered=4),
    ),
    Play(
        *("{one} -x /(scan_|add).* -m /scan:=/front", "under another name"),
        hears(front=4),
    ),
    Play(
        *("{one} --topics /scan -l", "starts again at the end"),
        lambda received: [value for _, value in received.scans[:6]] == [0, 1, 2, 3, 0, 1],
    ),
    Play(
        *("{one} --topics /scan -d 1.5 -l", "waits before each turn"),
        lambda received: (
            [time for time, _ in received.scans[:5]]
            == pytest.approx([1.5, 2.5, 3.5, 4.5, 6.0], abs=0.11)
        ),
        lambda stage: stage.run(8.0),
    ),
    Play(
        *("{one} --topics /scan --start-offset 1.5", "this many seconds into the bag"),
        lambda received: received.scans == [(0.5, 2), (1.5, 3)],
    ),
    Play(
        *("{one} --topics /scan --start-offset 1 --playback-duration 1.2", "of the played part"),
        lambda received: [value for _, value in received.scans] == [1, 2],
    ),
    Play(
        "{one} --playback-duration 0", "nothing is played", lambda received: not received.messages
    ),
    Play(
        *("{one} --topics /scan --playback-until-sec 101.5", "until this time"),
        lambda received: [value for _, value in received.scans] == [0, 1],
    ),
    Play(
        *(
            "{one} --topics /scan --playback-until-nsec 102000000000 --playback-duration 1",
            "the later of both",
        ),
        lambda received: [value for _, value in received.scans] == [0, 1, 2],
    ),
    Play(
        *("{one} --clock 10", "the time ten times a second, the recorded /clock left out"),
        lambda received: len(received.clock) == 36 and received.clock[:2] == [100.0, 100.1],
    ),
    Play(
        *("{one} --clock-topics /scan_filtered", "the time with each message of the topic"),
        lambda received: received.clock == [100.5, 101.5, 102.5, 103.5],
    ),
    Play(
        *("{one} --clock-topics-all --topics /scan", "the time with each message"),
        lambda received: received.clock == [100.0, 101.0, 102.0, 103.0],
    ),
    Play(
        *("-i {one} -i {two} mcap", "several bags, in the order of their times"),
        lambda received: (
            [name for _, name, _ in received.messages[:3]]
            == ["/scan", "/imu/data", "/scan_filtered"]
        ),
    ),
    Play(
        *("{one} --publish-service-requests", "the requests, not the events"),
        lambda received: received.asked == [5] and "/add/_service_event" not in received.topics,
    ),
    Play(
        *(
            "{one} --publish-service-requests --service-requests-source client_introspection",
            "those that the client noted: none",
        ),
        lambda received: received.asked == [] and "/add/_service_event" not in received.topics,
    ),
    Play(
        *("{one} --topics /scan -p", "begins paused; resumed by the service"),
        lambda received: [value for _, value in received.scans] == [0, 1, 2, 3],
        resumed_at_end,
    ),
    Play(
        *("{one} --topics /scan -p --read-ahead-queue-size 9", "keys: right, up, down, space"),
        lambda received: received.scans[0] == (0.2, 0) and len(received.scans) == 4,
        by_keys,
    ),
    Play(
        *("{one} --topics /scan --disable-keyboard-controls", "pause, step, burst, seek, rate"),
        lambda received: [value for _, value in received.scans] == [0, 1, 2, 3, 1, 2, 3],
        by_services,
    ),
    Play(
        *("burst {one} --topics /scan -n 3", "so many at once, then paused"),
        lambda received: received.scans == [(0.0, 0), (0.0, 1), (0.0, 2)],
        bursts,
    ),
    Play(
        *("burst {one} --start-offset 1.2 -m /scan:=/front", "all that are left"),
        lambda received: (
            [(t, v) for t, name, v in received.messages if name == "/front"] == [(0.0, 2), (0.0, 3)]
        ),
        bursts,
    ),
    Play(
        *("{one} --topics /scan --log-level error", "a service stops it"),
        lambda received: len(received.scans) == 2,
        stopped,
    ),
]


@pytest.mark.parametrize("row", PLAY, ids=lambda row: f"{row.words}: {row.promise}")
def test_play(row: Play, played_bags: dict[str, Path], bench: RosBench) -> None:
    verb = "" if row.words.startswith("burst") else "play "
    given = parsed(verb + row.words, **played_bags)
    if row.refused:
        with pytest.raises(ArjunaError, match=row.refused):
            Stage(bench, given)
        return
    with closing(Stage(bench, given)) as stage:
        row.during(stage)
    assert row.holds(stage.received)


def test_a_remapping_is_for_the_recording_and_not_for_the_player(
    played_bags: dict[str, Path], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["bag", "play", str(played_bags["one"]), "-r", "1000", "--remap", "/scan:=/front"]
    monkeypatch.setattr(sys, "argv", ["ros2", *words])
    assert main([*words, "--disable-keyboard-controls"]) == 0
    assert "This syntax is deprecated" not in capfd.readouterr().err


@dataclass(frozen=True)
class Other:
    """A call that needs no robot, what rosbag2 says of it, and what must be so then.

    Attributes:
        holds: Judges what was printed, and the folder in which `{out}` is.
        code: The exit code.
        file: The content of `{file}`.
    """

    words: str
    promise: str
    holds: Callable[[str, Path], bool]
    code: int = 0
    file: str = ""


def lines(*expected: str) -> Callable[[str, Path], bool]:
    """Return whether exactly these lines were printed."""
    return lambda printed, _: tuple(printed.splitlines()) == expected


def prints(*parts: str) -> Callable[[str, Path], bool]:
    """Return whether all parts were printed."""
    return lambda printed, _: all(part in printed for part in parts)


_ADD = "Service information: Service: /add | Type: example_interfaces/srv/AddTwoInts | "
_ALL = "all_topics: true, all_services: true, include_hidden_topics: true"
_MERGED = {"/clock": 1, "/imu/data": 1, "/scan": 4, "/scan_filtered": 4, "/add/_service_event": 1}
OTHERS = [
    Other(
        *("info {one}", "files, times, counts, services apart"),
        prints(
            "Files:             one_0.mcap\n                   one_1.mcap",
            *("ROS Distro:        jazzy", "Duration:          3.500000000s"),
            *("Messages:          10", "Service:           1"),
            f"{_ADD}Event Count: 1 | Serialization Format: cdr",
        ),
    ),
    Other(
        *("info {one} -t", "the topics' names alone"),
        lines("/clock", "/scan", "/scan_filtered"),
    ),
    Other(
        *("info {one} -v", "requests and responses of services"),
        prints(f"{_ADD}Request Count: 1 | Response Count: 0 | Serialization Format: cdr"),
    ),
    Other(
        *("convert -i {one} -i {two} mcap -o {file}", "merges, in the order of their times"),
        lambda _, out: (
            counts(out / "all") == _MERGED
            and [each.topic.name for each in Bag(out / "all").messages()][:2]
            == ["/scan", "/imu/data"]
            and packed(out / "all") == {".db3", ".yaml"}
        ),
        file=f"output_bags: [{{uri: OUT/all, storage_id: sqlite3, {_ALL}}}]",
    ),
    Other(
        *("convert -i {one} -o {file}", "splits by topics, compresses; nothing chosen is empty"),
        lambda _, out: (
            counts(out / "a") == {"/scan": 4}
            and packed(out / "a") == {".mcap.zstd", ".yaml"}
            and counts(out / "b") == {"/scan_filtered": 2}
            and counts(out / "c") == {}
        ),
        file="output_bags:\n- {uri: OUT/a, topics: [/scan], compression_mode: file,"
        " compression_format: zstd}\n- {uri: OUT/b, regex: filt, end_time_ns: 101500000000}\n"
        "- {uri: OUT/c}\n",
    ),
    Other(
        *("convert -i {one} -o {file}", "splits files by time"),
        lambda _, out: len(metadata(out / "d")["files"]) == 4,
        file="output_bags: [{uri: OUT/d, topics: [/scan], max_bagfile_duration: 1}]",
    ),
    Other(
        *("convert -i {one} -o {file}", "an unknown option is named"),
        *(prints("'max_size' is no option of an output; did you mean 'max_bagfile_size'?"), 1),
        "output_bags: [{uri: OUT/d, max_size: 1}]",
    ),
    Other(
        *("reindex {copy} -s mcap", "metadata.yaml from the files"),
        lambda _, out: (
            metadata(out / "copy")["message_count"] == 10 and counts(out / "copy")["/scan"] == 4
        ),
    ),
    Other("list storage", "the storage plug-ins", lines("mcap", "sqlite3")),
    Other("list compression --verbose", "with a description", prints("name: zstd\n\tZstd")),
    Other(
        *("play {one} -r 1000 --topics /scan", "rosbag2's sentences"),
        prints(
            "[rosbag2_player]: Set rate to 1000",
            "[rosbag2_player]: Adding keyboard callbacks.",
            "[rosbag2_player]: Press SPACE for Pause/Resume",
            "[rosbag2_player]: Press CURSOR_RIGHT for Play Next Message",
            "[rosbag2_player]: Playback until timestamp: -1",
        ),
    ),
    Other(
        *("play {one} -r 1000 --topics /scan --log-level warn", "silent below a level"),
        lines(),
    ),
    Other(
        *("record -a --qos-profile-overrides-path {file}", "half a duration is refused"),
        *(prints("[ERROR] [ros2bag]: Time overrides must include both seconds (sec) and"), 1),
        "/scan: {deadline: {sec: 1}}\n",
    ),
    Other(
        *("record -a --qos-profile-overrides-path {file}", "a depth is a number"),
        *(prints("[ERROR] [ros2bag]: depth is 'few', which is no int ("), 1),
        "/scan: {depth: few}\n",
    ),
    Other(
        *("record", "nothing to record is an error"),
        *(prints("[ERROR] [ros2bag]: Need to specify at least one option out of --all"), 1),
    ),
    Other(
        *("record --topics /scan --exclude-topics /a", "nothing to exclude from"),
        *(prints("--exclude-topics argument requires either --all, --all-topics"), 1),
    ),
    Other(
        *("record -a -o {one}", "a folder that exists is not written into"),
        *(prints("Output folder", "already exists."), 1),
    ),
    Other(
        *("record -a --use-sim-time --no-discovery", "incompatible"),
        *(prints("are incompatible settings"), 1),
    ),
    Other(
        *("record -a --compression-format zstd", "no format without a mode"),
        *(prints("Cannot specify compression format without a mode"), 1),
    ),
    Other(
        *("record -a -s sqlite3 -b 80000 -o {out}/x", "a size below the storage's least"),
        *(prints("invalid bag splitting size given: 80000; valid: 0 or at least 86016"), 1),
    ),
]


@pytest.mark.parametrize("row", OTHERS, ids=lambda row: f"{row.words}: {row.promise}")
def test_others(
    row: Other,
    played_bags: dict[str, Path],
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text(row.file.replace("OUT", str(tmp_path)))
    if "{copy}" in row.words:
        shutil.copytree(played_bags["one"], tmp_path / "copy")
        (tmp_path / "copy" / "metadata.yaml").unlink()
    paths = {**played_bags, "file": file, "out": tmp_path, "copy": tmp_path / "copy"}
    assert main(["bag", *(word.format(**paths) for word in row.words.split())]) == row.code
    assert row.holds("".join(capfd.readouterr()), tmp_path)
