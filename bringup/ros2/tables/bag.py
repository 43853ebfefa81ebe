"""`ros2 bag`: the verbs and options of rosbag2 0.26, Jazzy's."""

from __future__ import annotations

import argparse
from typing import Any

from bringup.ros2.grammar import Argument, Command, Verb, argument, switch
from bringup.ros2.tables.topic import rate, unsigned

LEVELS = ("debug", "info", "warn", "error", "fatal")
STORAGES = ("mcap", "sqlite3")
PLUGINS = {
    "storage": (
        ("mcap", "rosbag2 storage plugin for the mcap file format", "MCAPStorage"),
        ("sqlite3", "SQLite3 storage plugin", "SqliteStorage"),
    ),
    "converter": (("cdr_converter", "Converter of messages that are CDR already", "CdrConverter"),),
    "compression": (("zstd", "Zstd implementation for rosbag2 compressor", "ZstdCompressor"),),
    "decompression": (
        ("zstd", "Zstd implementation for rosbag2 decompressor", "ZstdDecompressor"),
    ),
}
"""What each kind's plug-ins are called, with rosbag2's names."""
_PRESETS = ("none", "fastwrite", "zstd_fast", "zstd_small", "resilient")


def from_zero(text: str) -> float:
    """Return a number from 0."""
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not number >= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no number from 0")
    return number


def names(*flags: str, about: str, metavar: str = "Topic") -> Argument:
    """Return an option of several names."""
    return argument(*flags, nargs="+", default=[], metavar=metavar, help=about)


_PATH = argument("bag_path", help="the recording: a folder, or a file of one")
_STORAGE = argument(
    *("-s", "--storage"), default="", choices=STORAGES, help="accepted: the files say what they are"
)
_READ = (_PATH, _STORAGE)
_INPUT: dict[str, Any] = {
    "action": "append",
    "nargs": "+",
    "metavar": ("uri", "storage_id"),
    "help": "a recording, and its storage if you like; may be repeated",
}
_OVERRIDES = argument(
    "--qos-profile-overrides-path", metavar="FILE", help="profiles of topics, a YAML file"
)
_CONFIG = argument(
    "--storage-config-file", metavar="FILE", help="settings of the storage, a YAML file"
)
_LEVEL = argument("--log-level", default="info", choices=LEVELS, help="what is printed at least")
_KEYS = switch("--disable-keyboard-controls", help="read no keys")
_QUEUE = argument(
    *("--read-ahead-queue-size",), type=int, default=1000, help="accepted: files are read as needed"
)
_REMAP = names(*("--remap", "-m"), metavar="OLD:=NEW", about="publish topics under other names")
_OFFSET = argument(
    *("--start-offset",), type=from_zero, default=0.0, help="begin this many seconds in"
)
_PLAYED = (
    _QUEUE,
    names("--topics", metavar="topic", about="only these topics"),
    names("--services", metavar="service", about="only these services"),
    _OVERRIDES,
    _REMAP,
    _CONFIG,
    _OFFSET,
)

_RECORD = (
    argument("-o", "--output", help="the folder (rosbag2_ and the time)"),
    argument("-s", "--storage", default="mcap", choices=STORAGES, help="how it is stored (mcap)"),
    (
        argument("topics_positional", nargs="*", default=[], metavar="Topic", help="the topics"),
        names("--topics", about="the topics"),
    ),
    names("--services", metavar="ServiceName", about="services whose events are recorded"),
    names("--topic-types", metavar="TopicType", about="topics of these types"),
    switch("-a", "--all", help="all topics and services, but hidden topics"),
    switch("--all-topics", help="all topics, but hidden ones"),
    switch("--all-services", help="the events of all services"),
    argument("-e", "--regex", default="", help="names in which this expression is found"),
    argument("-x", "--exclude-regex", default="", help="not names in which this is found"),
    names("--exclude-topic-types", metavar="TopicType", about="not topics of these types"),
    names("--exclude-topics", about="not these topics"),
    names("--exclude-services", metavar="ServiceName", about="not these services"),
    switch("--include-unpublished-topics", help="also topics without a publisher"),
    switch("--include-hidden-topics", help="also topics with a part that begins with _"),
    switch("--no-discovery", help="only the topics that are there at the start"),
    argument(
        *("-p", "--polling-interval"),
        type=unsigned,
        default=100,
        help="how often to look for topics [ms] (100)",
    ),
    switch("--ignore-leaf-topics", help="not topics without a subscription"),
    _OVERRIDES,
    argument("-f", "--serialization-format", default="", choices=["cdr"], help="cdr is all"),
    argument(
        *("-b", "--max-bag-size"),
        type=unsigned,
        default=0,
        help="bytes after which a new file begins (0, never)",
    ),
    argument(
        *("-d", "--max-bag-duration"),
        type=unsigned,
        default=0,
        help="seconds after which a new file begins (0, never)",
    ),
    argument(
        *("--max-cache-size",),
        type=unsigned,
        default=100 * 1024 * 1024,
        help="bytes that a snapshot holds; 0 writes every message at once (100 MiB)",
    ),
    _KEYS,
    switch("--start-paused", help="begin with a pause"),
    switch("--use-sim-time", help="stamp messages with /clock, and write none before it comes"),
    argument("--node-name", default="rosbag2_recorder", help="the recorder's node"),
    argument(
        *("--custom-data",), nargs="*", default=[], metavar="KEY=VALUE", help="for metadata.yaml"
    ),
    switch("--snapshot-mode", help="write what is held when the snapshot service is called"),
    _LEVEL,
    _CONFIG,
    argument(
        *("--storage-preset-profile",),
        default="none",
        choices=_PRESETS,
        help="settings of mcap (fastwrite, zstd_fast, zstd_small) or sqlite3 (resilient)",
    ),
    argument(
        *("--compression-queue-size",),
        type=int,
        default=1,
        help="accepted: nothing is dropped however much waits for compression",
    ),
    argument(
        *("--compression-threads",),
        type=unsigned,
        default=0,
        help="files that are compressed at once (0, one a core)",
    ),
    argument(
        *("--compression-threads-priority",), type=int, default=0, help="accepted, without effect"
    ),
    argument(
        *("--compression-mode",),
        default="none",
        choices=["none", "file", "message"],
        help="what is compressed (none)",
    ),
    argument("--compression-format", default="", choices=["zstd"], help="zstd is all"),
)

_PLAY = (
    argument("bag_path", nargs="?", help="the recording: a folder, or a file of one"),
    _STORAGE,
    argument("-i", "--input", **_INPUT),
    argument("-r", "--rate", type=rate, default=1.0, help="recorded seconds a second (1)"),
    *_PLAYED,
    argument("-e", "--regex", default="", help="only names that this expression fits"),
    argument("-x", "--exclude-regex", default="", help="not names that this fits"),
    names("--exclude-topics", metavar="topic", about="not these topics"),
    names("--exclude-services", metavar="service", about="not these services"),
    switch("-l", "--loop", help="begin again at the end"),
    (
        argument(
            *("--clock",),
            type=rate,
            nargs="?",
            const=40.0,
            default=0.0,
            metavar="HZ",
            help="publish the recorded time on /clock this often (40 Hz)",
        ),
        names("--clock-topics", metavar="topic", about="publish it with each of their messages"),
        switch("--clock-topics-all", help="publish it with each message"),
    ),
    argument("-d", "--delay", type=from_zero, default=0.0, help="wait before each turn [s] (0)"),
    argument(
        *("--playback-duration",),
        type=float,
        default=-1.0,
        help="end this many recorded seconds after the beginning",
    ),
    (
        argument(
            *("--playback-until-sec",), type=float, default=-1.0, help="end at this recorded time"
        ),
        argument(*("--playback-until-nsec",), type=int, default=-1, help="the same in nanoseconds"),
    ),
    _KEYS,
    switch("-p", "--start-paused", help="begin with a pause"),
    argument(
        *("--wait-for-all-acked",),
        type=unsigned,
        default=-1,
        metavar="TIMEOUT",
        help="wait at the end for who listens [ms], 0 for ever",
    ),
    switch("--disable-loan-message", help="accepted: messages are never loaned"),
    switch("--publish-service-requests", help="ask the services in place of publishing events"),
    argument(
        *("--service-requests-source",),
        default="service_introspection",
        choices=["service_introspection", "client_introspection"],
        help="whose events the requests are taken from",
    ),
    _LEVEL,
)

BAG = Command(
    *("bag", "Various rosbag related commands"),
    (
        Verb(
            *("burst", "Publish messages of a recording at once, then stand still"),
            (
                *_READ,
                *_PLAYED,
                argument(
                    *("-n", "--num-messages"),
                    type=unsigned,
                    default=0,
                    help="how many (0, all)",
                ),
            ),
        ),
        Verb(
            *("convert", "Write recordings again with other settings"),
            (
                argument("-i", "--input", required=True, **_INPUT),
                argument(
                    *("-o", "--output-options"),
                    required=True,
                    metavar="FILE",
                    help="a YAML file of output_bags",
                ),
            ),
        ),
        Verb(
            *("info", "Print information about a recording"),
            (
                *_READ,
                switch("-t", "--topic-name", help="only the names of the topics"),
                switch("-v", "--verbose", help="count requests and responses of services"),
            ),
        ),
        Verb(
            *("list", "Print the plug-ins that there are"),
            (
                argument(
                    *("plugin_type",),
                    choices=list(PLUGINS),
                    help="which kind",
                ),
                switch("--verbose", help="with a description"),
            ),
        ),
        Verb("play", "Publish a recording's messages", _PLAY),
        Verb("record", "Record topics and services", _RECORD),
        Verb("reindex", "Write the metadata.yaml of a folder again", _READ),
    ),
)
