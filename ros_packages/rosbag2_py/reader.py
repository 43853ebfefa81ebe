"""Recordings read message by message."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rclpy.duration import Duration
from rclpy.time import Time

from arjuna_core.bags.metadata import read_metadata
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage, TopicInfo
from arjuna_core.bags.writer import reindex
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.qos import profile_of
from bringup.recording import summary
from bringup.recording.selection import EVENTS, PlayFilter
from rosbag2_py.options import (
    BagMetadata,
    ConverterOptions,
    FileInformation,
    MessageDefinition,
    ReadOrder,
    ReadOrderSortBy,
    StorageFilter,
    StorageOptions,
    TopicInformation,
    TopicMetadata,
)
from rosbag2_py.qos import qos_from_profile


class SequentialReader:
    """Reads a recording's messages one after the other, of whatever storage and compression.

    Raises:
        RuntimeError: The recording cannot be read, none is open, or all has been read.
    """

    def __init__(self) -> None:
        self._bag: Bag | None = None
        self._filter = PlayFilter()
        self._reverse = False
        self._span: tuple[int, int] = (-1, -1)
        self._messages: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None

    def open(
        self, storage_options: StorageOptions, converter_options: ConverterOptions | None = None
    ) -> None:
        """Open a recording, which is read from its start."""
        try:
            self._bag = Bag(Path(storage_options.uri.removeprefix("file://")))
        except ArjunaError as error:
            raise RuntimeError(str(error)) from error
        self._span = storage_options.start_time_ns, storage_options.end_time_ns
        self._restart()

    def open_uri(self, uri: str) -> None:
        self.open(StorageOptions(uri))

    def close(self) -> None:
        self._bag, self._next, self._messages = None, None, iter(())

    def _current(self) -> Bag:
        if self._bag is None:
            raise RuntimeError("Bag is not open. Call open() before reading.")
        return self._bag

    def _restart(self, time: int | None = None) -> None:
        bag, (start, end) = self._current(), self._span
        first = max(start, 0 if time is None or self._reverse else time)
        last = time if self._reverse and time is not None else end
        found = bag.messages(self._filter.takes, first)
        if last >= 0:
            found = (message for message in found if message.time <= last)
        self._messages = iter(reversed(list(found))) if self._reverse else found
        self._next = next(self._messages, None)

    def has_next(self) -> bool:
        self._current()
        return self._next is not None

    def read_next(self) -> tuple[str, bytes, int]:
        """Return the next message's topic, its bytes and its time [ns]."""
        self._current()
        if self._next is None:
            raise RuntimeError("Bag is at end. No next message.")
        message, self._next = self._next, next(self._messages, None)
        return message.topic.name, bytes(message.data), message.time

    def seek(self, timestamp: int) -> None:
        """Continue at a time [ns]."""
        self._restart(timestamp)

    def set_filter(self, storage_filter: StorageFilter) -> None:
        """Read only some topics, from where it stands."""
        given = storage_filter
        self._filter = PlayFilter(
            topics=tuple(given.topics),
            services=tuple(each.removesuffix(EVENTS) for each in given.services_events),
            regex=given.regex,
            exclude_regex=given.regex_to_exclude,
            exclude_topics=tuple(given.exclude_topics),
            exclude_services=tuple(
                each.removesuffix(EVENTS) for each in given.exclude_service_events
            ),
        )
        if self._next is not None:
            self._restart(self._next.time)

    def reset_filter(self) -> None:
        self.set_filter(StorageFilter())

    def set_read_order(self, read_order: ReadOrder) -> bool:
        """Read from the end or the start; return whether messages can be sorted so."""
        if read_order.sort_by is not ReadOrderSortBy.ReceivedTimestamp:
            return False
        if self._reverse != read_order.reverse:
            self._reverse = read_order.reverse
            self._restart()
        return True

    def get_metadata(self) -> BagMetadata:
        return metadata_of(self._current())

    def get_all_topics_and_types(self) -> list[TopicMetadata]:
        return [_topic(each, number) for number, each in enumerate(_topics(self._current()), 1)]

    def get_all_message_definitions(self) -> list[MessageDefinition]:
        found = {each.type_name: each for each in _topics(self._current())}
        return [
            MessageDefinition(name, "ros2msg", each.definition, each.type_hash)
            for name, each in found.items()
        ]


class SequentialCompressionReader(SequentialReader):
    """The same: compression is noticed."""


class Info:
    """Reads a recording's metadata."""

    def read_metadata(self, uri: str, storage_id: str = "") -> BagMetadata:
        reader = SequentialReader()
        reader.open(StorageOptions(uri, storage_id))
        return reader.get_metadata()


class Reindexer:
    """Writes a folder's metadata.yaml again."""

    def reindex(self, storage_options: StorageOptions) -> None:
        """Write metadata.yaml from the folder's files."""
        try:
            reindex(Path(storage_options.uri))
        except ArjunaError as error:
            raise RuntimeError(str(error)) from error


def _topics(bag: Bag) -> list[TopicInfo]:
    return [topic for _, topic in sorted(bag.topics.items())]


def _topic(topic: TopicInfo, number: int) -> TopicMetadata:
    profiles = [qos_from_profile(profile_of(each)) for each in topic.offers]
    kind = topic.type_name
    return TopicMetadata(number, topic.name, kind, topic.encoding, profiles, topic.type_hash)


def metadata_of(bag: Bag) -> BagMetadata:
    counts = bag.counts
    given = read_metadata(bag.path) or {}
    files = [
        FileInformation(
            each.name,
            Time(nanoseconds=each.start),
            Duration(nanoseconds=each.end - each.start),
            each.messages,
        )
        for each in bag.files
    ]
    topics = [
        TopicInformation(_topic(each, number), counts[each.name])
        for number, each in enumerate(_topics(bag), 1)
    ]
    return BagMetadata(
        *(int(given.get("version", 9)), bag.size, bag.storage, [each.path for each in files]),
        *(files, Duration(nanoseconds=bag.end - bag.start), Time(nanoseconds=bag.start)),
        *(counts.total(), topics, given.get("compression_format") or ""),
        *(given.get("compression_mode") or "", given.get("custom_data") or {}, bag.distribution),
        "\n".join(summary.lines(bag)),
    )
