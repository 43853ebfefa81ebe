"""One mcap file of a recording: by its index where it has one, else record by record."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata, Schema
from mcap.summary import Summary

from arjuna_slam.logs.mcap_records import McapRecords
from bringup.recording.bags import topic as topics
from bringup.recording.bags.metadata import FileEntry
from bringup.recording.bags.topic import BagMessage, TopicInfo
from bringup.recording.bags.writer import LOSS_RECORD


class McapBag:
    """What an mcap file holds, and its messages.

    Args:
        path: The file.

    Attributes:
        topics: Its topics by name.
        entry: Its times and counts.
        lost: How many messages of a topic never reached the recorder.
        problems: What it lacks.

    Raises:
        InputFileError: It cannot be read or is no mcap.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, TopicInfo] = {}
        self.entry = FileEntry(path.name)
        self.lost: Counter[str] = Counter()
        self.problems: list[str] = []
        self._records = McapRecords(path)
        self._channels: dict[int, TopicInfo] = {}
        self._schemas: dict[int, Schema] = {}
        self._ordered = True
        summary = self._summary()
        if summary is None:
            self._count()
        else:
            self._take_summary(summary)

    @property
    def share(self) -> float:
        """Share (0..1) that has been read."""
        return self._records.share

    def messages(
        self, takes: Callable[[str], bool] = lambda topic: True, start: int = 0
    ) -> Iterator[BagMessage]:
        """Yield its messages in the order of their time.

        Args:
            takes: Tells which topics.
            start: From when on [ns].
        """
        if not self._ordered:
            yield from self._sorted(takes, start)
            return
        wanted = {key: each for key, each in self._channels.items() if takes(each.name)}
        for record in self._records.read(start):
            if isinstance(record, Message):
                topic = wanted.get(record.channel_id)
                if topic is not None and record.log_time >= start:
                    yield BagMessage(topic, record.log_time, record.data)
            elif isinstance(record, Channel | Schema):
                self._learn(record)
                wanted = {key: each for key, each in self._channels.items() if takes(each.name)}
        self._note_damages()

    def _sorted(self, takes: Callable[[str], bool], start: int) -> Iterator[BagMessage]:
        names = [name for name in self.topics if takes(name)]
        with self.path.open("rb") as file:
            for _, channel, message in make_reader(file).iter_messages(names, starting_at=start):
                yield BagMessage(self.topics[channel.topic], message.log_time, message.data)

    def _summary(self) -> Summary | None:
        summary = self._records.summary()
        return summary if summary and summary.statistics and summary.chunk_indexes else None

    def _take_summary(self, summary: Summary) -> None:
        for schema in summary.schemas.values():
            self._learn(schema)
        for channel in summary.channels.values():
            self._learn(channel)
        statistics = summary.statistics
        assert statistics is not None
        for key, count in statistics.channel_message_counts.items():
            if key in self._channels:
                self.entry.counts[self._channels[key].name] += count
        self.entry.start, self.entry.end = (
            statistics.message_start_time,
            statistics.message_end_time,
        )
        chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
        self._ordered = all(
            after.message_start_time >= before.message_end_time
            for before, after in pairwise(chunks)
        )
        with self.path.open("rb") as file:
            for metadata in make_reader(file).iter_metadata():
                self._take_metadata(metadata)

    def _count(self) -> None:
        """Find out what an index would say, from the records themselves."""
        for record in self._records.read():
            if isinstance(record, Channel | Schema):
                self._learn(record)
            elif isinstance(record, Metadata):
                self._take_metadata(record)
            elif isinstance(record, Message) and record.channel_id in self._channels:
                self.entry.count(self._channels[record.channel_id].name, record.log_time)
        self._note_damages()

    def _take_metadata(self, record: Metadata) -> None:
        if record.name == LOSS_RECORD:
            counts = {topic: int(text) for topic, text in record.metadata.items() if text.isdigit()}
            self.lost.update(counts)

    def _note_damages(self) -> None:
        for damage in self._records.damages:
            text = f"{self.path.name}: {damage}"
            if text not in self.problems:
                self.problems.append(text)

    def _learn(self, record: Channel | Schema) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
            return
        schema = self._schemas.get(record.schema_id)
        known = schema is not None and schema.encoding == "ros2msg"
        topic = TopicInfo(
            record.topic,
            schema.name if schema else "",
            schema.data.decode(errors="replace") if schema and known else "",
            record.metadata.get("topic_type_hash", ""),
            topics.parse(record.metadata.get("offered_qos_profiles", "")),
            record.message_encoding,
        )
        self._channels[record.id] = topic
        self.topics[record.topic] = topic
