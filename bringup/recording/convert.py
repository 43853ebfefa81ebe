"""Recordings written again into others, as `ros2 bag convert` does: merged, parted, compressed."""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from arjuna_core.bags.file_writer import RecordingError
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.bags.writer import STORAGES, BagFolder, BagFormat, SplitLimits
from arjuna_core.errors import ArjunaError, InputFileError, nearest
from arjuna_core.files.yaml_file import read_yaml
from bringup.recording.message_definitions import installed_type
from bringup.recording.selection import RecordFilter

NO_EFFECT = (
    *("max_cache_size", "snapshot_mode", "is_discovery_disabled", "rmw_serialization_format"),
    *("topic_polling_interval", "node_prefix", "compression_queue_size", "start_paused"),
    *("compression_threads_priority", "topic_qos_profile_overrides", "ignore_leaf_topics"),
    *("include_unpublished_topics", "use_sim_time", "disable_keyboard_controls"),
    *("input_serialization_format", "output_serialization_format"),
)
"""Options of rosbag2 for an output that mean nothing where recordings are written again."""
_LAYOUT: dict[str, Any] = {
    "storage_id": "",
    "storage_preset_profile": "",
    "storage_config_uri": "",
    "compression_mode": "",
    "compression_threads": 0,
    "custom_data": {},
    "max_bagfile_size": 0,
    "max_bagfile_duration": 0,
}
"""The options of a recording's layout, as `layout_of` takes them."""
_CHOICE: dict[str, Any] = {each.name: each.default for each in fields(RecordFilter)}
_DEFAULTS: dict[str, Any] = {
    "uri": "",
    "start_time_ns": -1,
    "end_time_ns": -1,
    "all": False,
    "exclude": "",
    "compression_format": "",
    **_LAYOUT,
    **{name: list(usual) if usual == () else usual for name, usual in _CHOICE.items()},
}


def layout_of(
    storage: str,
    preset: str,
    config: str,
    compression: str,
    threads: int,
    custom: Mapping[str, str],
    size: int,
    duration: float,
) -> tuple[SplitLimits, BagFormat]:
    """Return how a recording is written, by rosbag2's names; "" and 0 are the defaults everywhere.

    Args:
        compression: What is compressed: a file, or each message.
        threads: How many compress; 0 for as many as there are cores.
        size: Of a file [bytes].
        duration: Of a file [s].

    Raises:
        ArjunaError: A name is not known, or the size is below the storage's least.
    """
    storage, preset = storage or "mcap", preset or "none"
    mode = compression.lower().replace("none", "")
    for given, valid, what in (
        (storage, tuple(STORAGES), "storage"),
        (preset, STORAGES[storage].PRESETS if storage in STORAGES else (), "preset profile"),
        (mode, ("", "file", "message"), "compression mode"),
    ):
        if given not in valid:
            raise ArjunaError(f"'{given}' is no {what}; {nearest(given, valid)}")
    settings = read_yaml(Path(config)) if config else {}
    if not isinstance(settings, dict):
        raise InputFileError(Path(config), "holds no settings of a storage")
    least = STORAGES[storage].LEAST_SPLIT
    if 0 < size < least:
        raise ArjunaError(
            f"invalid bag splitting size given: {size}; valid: 0 or at least {least} bytes"
        )
    form = BagFormat(storage, preset, settings, mode, threads, custom)
    return SplitLimits(size, float(duration)), form


@dataclass(frozen=True)
class Output:
    """A recording to be written, and what of the others it takes.

    Attributes:
        start: The first time that it takes [ns].
        end: The last one [ns]; the end if negative.
    """

    folder: Path
    limits: SplitLimits
    format: BagFormat
    filter: RecordFilter
    start: int = -1
    end: int = -1


def read_outputs(path: Path) -> list[Output]:
    """Return the outputs that a file lists under `output_bags`.

    Raises:
        ArjunaError: There is none, or one is not as it should be.
    """
    content = read_yaml(path)
    bags = content.get("output_bags") if isinstance(content, dict) else None
    if not isinstance(bags, list) or not bags:
        raise InputFileError(path, "lists no recordings; valid: output_bags: [{uri: FOLDER}]")
    return [_output(path, each) for each in bags]


def _output(path: Path, given: Any) -> Output:
    if not isinstance(given, dict) or not given.get("uri"):
        raise InputFileError(path, f"an output has no uri: {given}")
    for name in given:
        if name not in _DEFAULTS and name not in NO_EFFECT:
            problem = f"'{name}' is no option of an output; {nearest(str(name), _DEFAULTS)}"
            raise InputFileError(path, problem)
    for name, value in given.items():
        if name in _DEFAULTS and not isinstance(value, type(_DEFAULTS[name])):
            kind = type(_DEFAULTS[name]).__name__
            raise InputFileError(path, f"{name}: {value!r} is no {kind}")
    options = {**_DEFAULTS, **given}
    options["exclude_regex"] = options["exclude_regex"] or options["exclude"]
    for name in ("all_topics", "all_services"):
        options[name] = options[name] or options["all"]
    choice = {name: type(usual)(options[name]) for name, usual in _CHOICE.items()}
    layout = layout_of(*(options[name] for name in _LAYOUT))
    times = options["start_time_ns"], options["end_time_ns"]
    return Output(Path(options["uri"]), *layout, RecordFilter(**choice), *times)


def convert(bags: Sequence[Bag], outputs: Sequence[Output]) -> None:
    """Write the messages of recordings, in the order of their times, into others.

    Raises:
        RecordingError: An output exists, or the disk refuses.
    """
    known = {name: _defined(topic) for bag in bags for name, topic in bag.topics.items()}
    for each in outputs:
        if each.folder.exists():
            raise RecordingError(f"{each.folder} exists already and is not overwritten")
    folders = [BagFolder(each.folder, each.limits, each.format) for each in outputs]
    takers: dict[str, list[tuple[Output, BagFolder]]] = {}
    for name, topic in sorted(known.items()):
        takers[name] = [
            (output, folder)
            for output, folder in zip(outputs, folders, strict=True)
            if output.filter.takes(name, topic.type_name)
        ]
        for _, folder in takers[name]:
            folder.add_topic(topic)
    found = [bag.messages(lambda name: bool(takers[name])) for bag in bags]
    for message in heapq.merge(*found, key=lambda each: each.time):
        name, time = message.topic.name, message.time
        for output, folder in takers[name]:
            if output.start <= time and (output.end < 0 or time <= output.end):
                folder.write(known[name], time, message.data, time)
    for folder in folders:
        folder.close()


def _defined(topic: TopicInfo) -> TopicInfo:
    """Return a topic with its type's definition, the installed one where it has none."""
    return replace(topic, definition=topic.definition or installed_type(topic.type_name)[0])
