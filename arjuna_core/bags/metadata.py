"""The files of a recording, and metadata.yaml, by which rosbag2 knows a folder as a recording."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import yaml

from arjuna_core.bags.topic import BagMessage, PlainDumper, TopicInfo
from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import read_yaml

METADATA = "metadata.yaml"


@dataclass
class FileEntry:
    """One file of a recording.

    Attributes:
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


class BagFile(ABC):
    """One file of a recording, read past damage or as far as it goes.

    Attributes:
        topics: Its topics by name.
        lost: How many messages of a topic never reached the recorder.
        share: Share (0..1) that has been read.

    Raises:
        InputFileError: It cannot be read or is no such file.
    """

    KIND: ClassVar[str]
    DAMAGE: ClassVar[tuple[type[Exception], ...]]

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, TopicInfo] = {}
        self.entry = FileEntry(path.name)
        self.lost: Counter[str] = Counter()
        self.problems: list[str] = []
        self.share = 0.0
        try:
            damage = self._take_index()
        except self.DAMAGE as error:
            problem = f"is no {self.KIND} recording: {reason_of(error)}"
            raise InputFileError(path, problem) from error
        if damage:
            self._note_end(damage)

    @abstractmethod
    def _take_index(self) -> str:
        """Learn topics, times and counts; return the damage that ended that, or nothing."""

    def messages(self, takes: Callable[[str], bool], start: int = 0) -> Iterator[BagMessage]:
        """Yield the messages of wanted topics from a time [ns] on, in the order of their time."""
        try:
            yield from self._messages(takes, start)
        except self.DAMAGE as error:
            self._note_end(reason_of(error))

    @abstractmethod
    def _messages(self, takes: Callable[[str], bool], start: int) -> Iterator[BagMessage]:
        """Yield messages as `messages` does, up to damage that raises."""

    def _note_end(self, damage: str) -> None:
        self._note(f"damaged or cut short ({damage}); read up to there")

    def _note(self, problem: str) -> None:
        text = f"{self.path.name}: {problem}"
        if text not in self.problems and len(self.problems) < 100:
            self.problems.append(text)


def reason_of(error: BaseException) -> str:
    """Return an error's text in one line, or its kind where it has none."""
    return " ".join(str(error).split()) or type(error).__name__


def read_metadata(folder: Path) -> dict[str, Any] | None:
    """Return the information in a folder's metadata; None where it has none.

    Raises:
        InputFileError: It is no metadata of rosbag2.
    """
    path = folder / METADATA
    if not os.path.lexists(path):
        return None
    try:
        found = read_yaml(path)["rosbag2_bagfile_information"]
        names = [Path(name).name for name in found["relative_file_paths"]]
        return {**found, "relative_file_paths": names}
    except (ValueError, LookupError, TypeError) as error:
        raise InputFileError(path, f"is no metadata of rosbag2: {error}") from error


def metadata_yaml(
    topics: Iterable[TopicInfo],
    files: Sequence[FileEntry],
    storage: str = "mcap",
    compression: str = "",
    custom: Mapping[str, str] | None = None,
    counts: Counter[str] | None = None,
) -> str:
    """Return the text of metadata.yaml.

    Args:
        compression: "" for none, `file` or `message`.
        counts: How many messages of each topic there are; the sum of the files' if None.
    """
    used = [file for file in files if file.counts]
    start = min((file.start for file in used), default=0)
    end = max((file.end for file in used), default=0)
    counts = sum((file.counts for file in files), Counter[str]()) if counts is None else counts
    information = {
        "version": 9,  # rosbag2's of Jazzy
        "storage_identifier": storage,
        **_span(start, end),
        "message_count": counts.total(),
        "topics_with_message_count": [
            {"topic_metadata": _topic(topic), "message_count": counts[topic.name]}
            for topic in topics
        ],
        "compression_format": "zstd" if compression else "",
        "compression_mode": compression.upper(),
        "relative_file_paths": [file.name for file in files],
        "files": [
            {"path": file.name, **_span(file.start, file.end), "message_count": file.messages}
            for file in files
        ],
        "custom_data": dict(custom) if custom else None,
        "ros_distro": "jazzy",
    }
    return str(yaml.dump({"rosbag2_bagfile_information": information}, Dumper=PlainDumper))


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
