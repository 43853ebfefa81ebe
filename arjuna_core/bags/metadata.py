"""metadata.yaml, by which rosbag2 knows a folder as a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.bags.topic import TopicInfo
from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import plain

METADATA = "metadata.yaml"


@dataclass
class FileEntry:
    """One file of a recording.

    Attributes:
        name: Its name.
        start: When its first message was received [ns].
        end: When its last one was [ns].
        counts: How many messages of each topic it holds.
    """

    name: str
    start: int = 0
    end: int = 0
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def messages(self) -> int:
        """Number of its messages."""
        return self.counts.total()

    def count(self, topic: str, time: int) -> None:
        """Note a message of a topic that was received at a time [ns]."""
        self.start = min(self.start, time) if self.counts else time
        self.end = max(self.end, time)
        self.counts[topic] += 1


def read_metadata(folder: Path) -> dict[str, Any] | None:
    """Return the information in a folder's metadata; None where it has none.

    Raises:
        InputFileError: It is no metadata of rosbag2.
    """
    path = folder / METADATA
    if not path.is_file():
        return None
    try:
        found = plain(path.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [Path(name).name for name in found["relative_file_paths"]]
        return {**found, "relative_file_paths": names}
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise InputFileError(path, f"is no metadata of rosbag2: {error}") from error


def metadata_yaml(topics: Iterable[TopicInfo], files: Sequence[FileEntry]) -> str:
    """Return the text of a recording's metadata.yaml."""
    used = [file for file in files if file.counts]
    start = min((file.start for file in used), default=0)
    end = max((file.end for file in used), default=0)
    counts = sum((file.counts for file in files), Counter[str]())
    information = {
        "version": 9,  # rosbag2's of Jazzy
        "storage_identifier": "mcap",
        **_span(start, end),
        "message_count": counts.total(),
        "topics_with_message_count": [
            {"topic_metadata": _topic(topic), "message_count": counts[topic.name]}
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [
            {"path": file.name, **_span(file.start, file.end), "message_count": file.messages}
            for file in files
        ],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    return str(yaml.dump({"rosbag2_bagfile_information": information}, Dumper=_Plain))


def _span(start: int, end: int) -> dict[str, Any]:
    return {
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
    }


def _topic(topic: TopicInfo) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.type_name,
        "serialization_format": topic.encoding,
        "offered_qos_profiles": [each.to_rosbag2() for each in topic.offers],
        "type_description_hash": topic.type_hash,
    }


class _Plain(yaml.SafeDumper):
    """Writes in the given order and repeats what occurs twice: rosbag2 reads no anchors here."""

    def __init__(self, stream: Any, **options: Any) -> None:
        super().__init__(stream, **{**options, "sort_keys": False})

    def ignore_aliases(self, data: Any) -> bool:
        return True
