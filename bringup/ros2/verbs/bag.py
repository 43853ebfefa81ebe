"""`ros2 bag`: rosbag2's options to those of the recorder, the player and their files."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from rclpy.logging import LoggingSeverity, get_logger
from rclpy.qos import QoSProfile

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.writer import STORAGES, BagFolder
from arjuna_core.bags.writer import reindex as write_metadata
from arjuna_core.errors import InputFileError
from arjuna_core.timing import NANOSECONDS
from bringup.recording import summary
from bringup.recording.convert import convert as write_outputs
from bringup.recording.convert import layout_of, read_outputs
from bringup.recording.play import play as publish
from bringup.recording.playback import PlayOptions
from bringup.recording.player import REQUESTS
from bringup.recording.qos_overrides import read_overrides
from bringup.recording.record import record as write
from bringup.recording.recorder import RecordOptions
from bringup.recording.selection import PlayFilter, RecordFilter, is_service
from bringup.ros2.errors import Ros2Error
from bringup.terminal import show

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
"""The names of each kind's plug-ins, as rosbag2 has them."""


class BagError(Ros2Error):
    """A verb of `ros2 bag` failed, in ros2bag's words."""

    def __init__(self, problem: str) -> None:
        super().__init__(f"[ERROR] [ros2bag]: {problem}")


def record(arguments: argparse.Namespace) -> None:
    """Record until stopped."""
    options = record_options(arguments)
    folder = folder_of(arguments)
    if folder.format.storage == "sqlite3":
        opened = folder.path / folder.files[0].name
        logged("rosbag2_storage", arguments.log_level)(
            f"Opened database '{opened}' for READ_WRITE."
        )
    write(folder, options, logged(options.node_name, arguments.log_level))


def record_options(given: argparse.Namespace) -> RecordOptions:
    """Return the recorder's options."""
    chosen = record_filter(given)
    others = chosen.all_topics or chosen.all_services or chosen.services or chosen.regex
    return RecordOptions(
        takes=chosen.takes,
        requested=() if others or chosen.topic_types else chosen.topics,
        node_name=given.node_name,
        controlled=True,
        keys=not given.disable_keyboard_controls,
        overrides=_overrides(given.qos_profile_overrides_path),
        discovery=not given.no_discovery,
        polling_period=given.polling_interval / 1000.0,
        unpublished=given.include_unpublished_topics,
        leaves=not given.ignore_leaf_topics,
        paused=given.start_paused,
        sim_time=given.use_sim_time,
        snapshot=given.snapshot_mode,
        cache=given.max_cache_size,
    )


def record_filter(given: argparse.Namespace) -> RecordFilter:
    """Return the choice of topics, once it is known to be one.

    Raises:
        BagError: Nothing is chosen, or something is excluded of nothing.
    """
    topics = [*given.topics_positional, *given.topics]
    if given.topics_positional:
        use = 'Please use optional "--topics" argument instead.'
        show(f'[WARN] [ros2bag]: Positional "topics" argument deprecated. {use}')
    all_topics, all_services = given.all or given.all_topics, given.all or given.all_services
    chosen = all_topics or all_services or given.services or given.topic_types or given.regex
    if not chosen and not topics:
        raise BagError(
            "Need to specify at least one option out of --all, --all-topics, --all-services, "
            "--services, --topics, --topic-types or --regex"
        )
    by_topics = all_topics or given.topic_types or given.regex
    by_services = all_services or given.regex
    for option, needed, what in (
        ("exclude_regex", by_topics or by_services, "--all-topics, --topic-types, --all-services"),
        ("exclude_topics", by_topics, "--all-topics, --topic-types"),
        ("exclude_topic_types", by_topics, "--all-topics"),
        ("exclude_services", by_services, "--all-services"),
    ):
        if getattr(given, option) and not needed:
            name = option.replace("_", "-")
            raise BagError(f"--{name} argument requires either --all, {what} or --regex")
    for overriding, overridden, text in (
        (all_services, given.services, "--all or --all-services will override --services"),
        (all_topics, topics, "--all or --all-topics will override --topics"),
        (
            all_topics or all_services,
            given.regex,
            "--all, --all-topics or --all-services will override --regex",
        ),
    ):
        if overriding and overridden:
            show(f"[WARN] [ros2bag]: {text}")
    return RecordFilter(
        *(all_topics, all_services, _absolute(topics), tuple(given.topic_types)),
        *(_absolute(given.services), "" if all_topics or all_services else _regex(given.regex)),
        *(_regex(given.exclude_regex), _absolute(given.exclude_topics)),
        *(tuple(given.exclude_topic_types), _absolute(given.exclude_services)),
        given.include_hidden_topics,
    )


def folder_of(given: argparse.Namespace) -> BagFolder:
    """Make the folder of a recording.

    Raises:
        BagError: Options contradict one another.
    """
    folder = Path(given.output or f"{datetime.now().astimezone():rosbag2_%Y_%m_%d-%H_%M_%S}")
    if folder.is_dir():
        raise BagError(f"Output folder '{folder}' already exists.")
    if given.use_sim_time and given.no_discovery:
        raise BagError(
            "--use-sim-time and --no-discovery both set, but are incompatible settings. "
            "The /clock topic needs to be discovered to record with sim time."
        )
    if given.compression_format and given.compression_mode == "none":
        raise BagError("Invalid choice: Cannot specify compression format without a mode.")
    if given.compression_queue_size < 0:
        raise BagError("Compression queue size must be at least 0.")
    pairs = dict(_pair(text) for text in given.custom_data)
    layout = layout_of(
        *(given.storage, given.storage_preset_profile, given.storage_config_file),
        *(given.compression_mode, given.compression_threads, pairs),
        *(given.max_bag_size, given.max_bag_duration),
    )
    return BagFolder(folder, *layout)


def play(arguments: argparse.Namespace) -> None:
    """Play until the end, or until stopped."""
    bags, options = bags_of(arguments), play_options(arguments)
    for bag in bags:
        if bag.current_file.suffix == ".db3":
            opened = f"Opened database '{bag.current_file}' for READ_ONLY."
            logged("rosbag2_storage", arguments.log_level)(opened)
    log = logged(options.node_name, arguments.log_level)
    publish(bags, until(options, bags, arguments), log)


def burst(arguments: argparse.Namespace) -> None:
    """Publish the next messages at once, then stand still until stopped."""
    options = burst_options(arguments)
    publish([Bag(Path(arguments.bag_path))], options, logged(options.node_name))


def burst_options(given: argparse.Namespace) -> PlayOptions:
    """Return the options of a player that stands still behind its first messages."""
    return replace(_played(given), paused=True, burst=given.num_messages)


def bags_of(given: argparse.Namespace) -> list[Bag]:
    """Return the recordings to play.

    Raises:
        BagError: None is given, or in both forms.
    """
    if (given.bag_path is None) == (given.input is None):
        raise BagError("Must specify either a bag path or --input, and not both.")
    return [Bag(Path(given.bag_path))] if given.bag_path else _inputs(given.input)


def _inputs(given: list[list[str]]) -> list[Bag]:
    for uri, *storages in given:
        if len(storages) > 1:
            raise BagError(f"--input expects 1 or 2 arguments, {1 + len(storages)} provided")
        if storages and storages[0] not in STORAGES:
            valid = ", ".join(STORAGES)
            raise BagError(f"Unknown storage ID '{storages[0]}' of {uri}, options are: {valid}")
    return [Bag(Path(uri)) for uri, *_ in given]


def play_options(given: argparse.Namespace) -> PlayOptions:
    """Return the player's options, but for the end of what is played."""
    acked = given.wait_for_all_acked
    return replace(
        _played(given),
        rate=given.rate,
        paused=given.start_paused,
        loop=given.loop,
        clock_hz=given.clock,
        clock_topics=None if given.clock_topics_all else _absolute(given.clock_topics),
        delay=given.delay,
        acked_timeout=acked / 1000.0 if acked >= 0 else None,
        requests=REQUESTS[given.service_requests_source]
        if given.publish_service_requests
        else None,
        keys=not given.disable_keyboard_controls,
    )


def _played(given: argparse.Namespace) -> PlayOptions:
    """Return what `play` and `burst` have in common."""
    absent = argparse.Namespace(regex="", exclude_regex="", exclude_topics=[], exclude_services=[])
    each = argparse.Namespace(**{**vars(absent), **vars(given)})
    chosen = PlayFilter(
        *(_absolute(each.topics), _absolute(each.services), _regex(each.regex)),
        *(_regex(each.exclude_regex), _absolute(each.exclude_topics)),
        _absolute(each.exclude_services),
    )
    return PlayOptions(
        takes=chosen.takes,
        offset=given.start_offset,
        remap=dict(_remapped(text) for text in given.remap),
        overrides=_overrides(given.qos_profile_overrides_path),
        recorded_clock=False,
        node_name="rosbag2_player",
        controlled=True,
    )


def until(options: PlayOptions, bags: list[Bag], given: argparse.Namespace) -> PlayOptions:
    """Return options with the time at which playing ends: the later one of the two that end it."""
    ends = []
    if given.playback_duration == 0.0:
        ends.append(0)
    elif given.playback_duration > 0.0:
        start = min(bag.start for bag in bags) + round(options.offset * NANOSECONDS)
        ends.append(start + round(given.playback_duration * NANOSECONDS))
    ends += [given.playback_until_nsec] if given.playback_until_nsec >= 0 else []
    ends += [round(given.playback_until_sec * NANOSECONDS)] if given.playback_until_sec >= 0 else []
    return replace(options, until=max(ends)) if ends else options


def info(arguments: argparse.Namespace) -> None:
    """Print information about a recording."""
    if arguments.topic_name and arguments.verbose:
        show(
            "Warning! You have set both the '-t' and '-v' parameters. The '-t' parameter will be "
            "ignored."
        )
    bag = Bag(Path(arguments.bag_path))
    if arguments.topic_name and not arguments.verbose:
        for name, topic in sorted(bag.topics.items()):
            if not is_service(name, topic.type_name):
                show(name)
        return
    show("")
    for line in summary.lines(bag, arguments.verbose):
        show(line)


def convert(arguments: argparse.Namespace) -> None:
    """Write recordings again with other settings."""
    write_outputs(_inputs(arguments.input), read_outputs(Path(arguments.output_options)))


def reindex(arguments: argparse.Namespace) -> None:
    """Write the metadata.yaml of a folder again."""
    folder = Path(arguments.bag_path)
    if not folder.is_dir():
        raise BagError("Must specify a bag directory")
    write_metadata(folder)
    show("Reindexing complete.")


def list_(arguments: argparse.Namespace) -> None:
    """Print the plug-ins of a kind."""
    kind = arguments.plugin_type
    if arguments.verbose:
        show(f"available {kind} plugins are:")
    for name, about, cls in PLUGINS[kind]:
        show(f"name: {name}\n\t{about}\n\ttype: {cls}" if arguments.verbose else name)


def logged(node_name: str, level: str = "info") -> Callable[[str], None]:
    """Return what logs the lines of a run, of the level `info`, on standard error as a node's."""
    logger = get_logger(node_name)
    logger.set_level(LoggingSeverity[level.upper()])
    return lambda line: logger.info(line)


def _overrides(path: str | None) -> dict[str, QoSProfile]:
    """Return the profiles of topics in a file."""
    try:
        return read_overrides(Path(path)) if path else {}
    except InputFileError as error:
        raise BagError(f"{error.problem} ({path})") from error


def _absolute(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"/{name.lstrip('/')}" for name in names)


def _regex(text: str) -> str:
    try:
        re.compile(text)
    except re.error as error:
        raise BagError(f"{text!r} is no regular expression: {error}") from error
    return text


def _pair(text: str) -> tuple[str, str]:
    key, sign, value = text.partition("=")
    if not sign:
        raise BagError(f"custom data {text!r} is no KEY=VALUE")
    return key, value


def _remapped(text: str) -> tuple[str, str]:
    old, sign, new = text.partition(":=")
    if not (sign and old.strip("/") and new.strip("/")):
        raise BagError(f"{text!r} is no remapping; valid: old_topic:=new_topic")
    return f"/{old.strip('/')}", f"/{new.strip('/')}"
