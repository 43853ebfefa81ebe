"""Recordings made by hand: messages as bytes, in mcap files and bags of any ROS."""

from __future__ import annotations

import math
import struct
from functools import cache
from pathlib import Path
from typing import Any

from mcap.writer import Writer
from rosbags import rosbag1, rosbag2
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from arjuna_core.bags.decoder import Decoder
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo, TopicQos
from arjuna_core.bags.writer import BagFolder, BagFormat, SplitLimits
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

SCAN, ODOMETRY, TF = (
    "sensor_msgs/msg/LaserScan",
    "nav_msgs/msg/Odometry",
    "tf2_msgs/msg/TFMessage",
)


@cache
def types_of(release: Stores) -> Typestore:
    """Return a release's types, with a tree of transforms; they take 0.3 s to read."""
    store = get_typestore(release)
    if release is Stores.ROS1_NOETIC:
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
    return store


class Cdr:
    """Writes values as CDR, little or big end first."""

    def __init__(self, order: str = "<") -> None:
        self.order = order
        self.body = b""

    def put(self, code: str, *values: float) -> Cdr:
        size = struct.calcsize(code)
        for value in values:
            self.body += b"\0" * (-len(self.body) % size)
            self.body += struct.pack(self.order + code, value)
        return self

    def text(self, value: str) -> Cdr:
        self.put("I", len(value) + 1)
        self.body += value.encode() + b"\0"
        return self

    def header(self, stamp: float, frame: str) -> Cdr:
        sec, nanosec = divmod(round(stamp * 1e9), 10**9)
        return self.put("i", sec).put("I", nanosec).text(frame)

    def pose(self, pose: SE2, upside_down: bool = False) -> Cdr:
        s, c = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
        turn = (c, s, 0.0, 0.0) if upside_down else (0.0, 0.0, s, c)  # about x first, then z
        return self.put("d", pose.x, pose.y, 0.0, *turn)

    def bytes(self) -> bytes:
        return (b"\0\1\0\0" if self.order == "<" else b"\0\0\0\0") + self.body


def scan_bytes(scan: Scan, frame: str = "laser", order: str = "<") -> bytes:
    cdr = Cdr(order).header(scan.stamp, frame)
    last = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    cdr.put("f", scan.angle_min, last, scan.angle_increment, scan.time_increment, 0.1)
    cdr.put("f", scan.range_min, scan.range_max)
    cdr.put("I", len(scan.ranges)).put("f", *scan.ranges)
    return cdr.put("I", 0).bytes()


def odometry_bytes(pose: SE2, stamp: float) -> bytes:
    cdr = Cdr().header(stamp, "odom").text("base_link").pose(pose)
    return cdr.put("d", *[0.0] * 36).put("d", *[0.0] * 42).bytes()


def transform_bytes(*transforms: tuple[str, str, SE2, float], upside_down: bool = False) -> bytes:
    cdr = Cdr().put("I", len(transforms))
    for parent, child, pose, stamp in transforms:
        cdr.header(stamp, parent).text(child).pose(pose, upside_down)
    return cdr.bytes()


def decoded(kind: str, data: bytes) -> Any:
    return Decoder().decode(TopicInfo("/topic", kind), data)


Entry = tuple[str, str, float, bytes]


def write(
    path: Path,
    entries: list[Entry],
    encoding: str = "cdr",
    chunk: int = 20000,
    definition: bytes = b"",
) -> Path:
    """Write topic, type, time [s] and bytes of each message to an mcap file."""
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=chunk)
        writer.start(profile="ros2", library="test")
        channels: dict[str, int] = {}
        for topic, kind, stamp, data in entries:
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", definition)
                channels[topic] = writer.register_channel(topic, encoding, schema)
            now = round(stamp * 1e9)
            writer.add_message(channels[topic], now, data, now)
        writer.finish()
    return path


def write_humble(
    folder: Path, entries: list[Entry], storage: str = "SQLITE3", packed: str = "NONE"
) -> Path:
    """Write a rosbag2 folder with the message definitions of ROS 2 Humble.

    Args:
        packed: What is compressed: NONE, FILE or MESSAGE.
    """
    writer = rosbag2.Writer(folder, version=8, storage_plugin=StoragePlugin[storage])
    writer.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    types = types_of(Stores.ROS2_HUMBLE)
    with writer as bag:
        channels: dict[str, Any] = {}
        for topic, kind, stamp, data in entries:
            if topic not in channels:
                channels[topic] = bag.add_connection(topic, kind, typestore=types)
            bag.write(channels[topic], round(stamp * 1e9), data)
    return folder


def write_ros1(path: Path, entries: list[Entry], chunk: int = 1 << 20) -> Path:
    """Write a bag of ROS 1."""
    writer = rosbag1.Writer(path)
    writer.chunk_threshold = chunk
    types, humble = types_of(Stores.ROS1_NOETIC), types_of(Stores.ROS2_HUMBLE)
    writer.set_compression(writer.CompressionFormat.BZ2)
    with writer as bag:
        channels: dict[str, Any] = {}
        for topic, kind, stamp, data in entries:
            if topic not in channels:
                channels[topic] = bag.add_connection(topic, kind, typestore=types)
            bag.write(channels[topic], round(stamp * 1e9), humble.cdr_to_ros1(data, kind))
    return path


NUMBER = TopicInfo(
    "/number", "std_msgs/msg/Int32", "int32 data\n", "RIHS01_0", (TopicQos(depth=5),)
)
LATCHED = TopicInfo(
    "/word", "std_msgs/msg/String", "string data\n", "RIHS01_1", (TopicQos(latched=True, depth=1),)
)
MS = 1_000_000


def write_numbers(
    folder: Path,
    count: int = 100,
    limits: SplitLimits | None = None,
    form: BagFormat | None = None,
) -> BagFolder:
    """Write a message each millisecond, flushed each ten; the folder is not closed."""
    bag = BagFolder(folder, limits or SplitLimits(), form or BagFormat())
    for number in range(count):
        topic = LATCHED if number % 10 == 0 else NUMBER
        bag.write(topic, number * MS, bytes([0, 1, 0, 0, number % 256, 0, 0, 0]), number * MS)
        if number % 10 == 9:
            bag.flush()
    return bag


def write_words(folder: Path, storage: str, packed: str) -> Path:
    """Write 2000 words as a rosbag2 folder; see `write_humble`."""
    stored = [
        (LATCHED.name, LATCHED.type_name, 0.001 * n, Cdr().text(f"word {n}").bytes())
        for n in range(2000)
    ]
    return write_humble(folder, stored, storage, packed)


def times(bag: Bag) -> list[int]:
    """Return the times of a bag's messages [ms]."""
    return [message.time // MS for message in bag.messages()]


ENTRIES: list[Entry] = [
    ("/tf", TF, 0.1 * k, transform_bytes(("odom", "base_link", SE2(float(k)), 0.1 * k)))
    for k in range(1, 41)
]
