"""Mcap files: read past damage, and as far as a file that was cut short goes."""

from __future__ import annotations

import heapq
import itertools
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from io import BytesIO
from typing import Any, BinaryIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, ChunkIndex, Footer, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary

from arjuna_core.bags import topic as topics
from arjuna_core.bags.metadata import BagFile, reason_of
from arjuna_core.bags.topic import BagMessage, TopicInfo
from arjuna_core.errors import InputFileError

LOSS_RECORD = "arjuna_lost_messages"
"""Name of the mcap metadata record that counts by topic the messages that never arrived."""

_MAGIC = b"\x89MCAP0\r\n"
_DAMAGE = (
    *(McapError, zstandard.ZstdError, ValueError, RuntimeError, KeyError, struct.error),
    *(EOFError, MemoryError, OverflowError),
)
_HEAD = struct.Struct("<BQ")  # opcode and length of a record; mcap.dev/spec
_SINGLE: dict[int, Callable[..., Any]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.FOOTER: Footer.read,
}
_Record = Schema | Channel | Message | Metadata | Footer


class McapFile(BagFile):
    """The topics and messages of an mcap file."""

    KIND = "mcap"
    DAMAGE = ()  # it is noted where it stands, and read past

    def _take_index(self) -> str:
        self._channels: dict[int, TopicInfo] = {}
        self._schemas: dict[int, Schema] = {}
        self._unordered: list[ChunkIndex] = []
        with self._open() as file:
            summary = _summary(file)
        if summary is None:
            self._count()
        else:
            self._take_summary(summary)
        return ""

    def _open(self) -> BinaryIO:
        try:
            file = self.path.open("rb")
        except OSError as error:
            problem = f"cannot be read: {error.strerror or error}"
            raise InputFileError(self.path, problem) from error
        if file.read(len(_MAGIC)) == _MAGIC:
            return file
        file.close()
        raise InputFileError(self.path, "is no mcap recording: it does not begin as one")

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
        self.entry.start = statistics.message_start_time
        self.entry.end = statistics.message_end_time
        chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
        if any(b.message_start_time < a.message_end_time for a, b in itertools.pairwise(chunks)):
            self._unordered = sorted(chunks, key=lambda chunk: chunk.message_start_time)
        with self._open() as file:
            for index in summary.metadata_indexes:
                file.seek(index.offset)
                for record in self._next(file, 0) or ():
                    self._learn(record)

    def _count(self) -> None:
        for record in self._read(0):
            if isinstance(record, Message) and record.channel_id in self._channels:
                self.entry.count(self._channels[record.channel_id].name, record.log_time)

    def _messages(self, takes: Callable[[str], bool], start: int) -> Iterator[BagMessage]:
        wanted = cache(takes)
        for record in self._merged(start) if self._unordered else self._read(start):
            if isinstance(record, Message) and record.log_time >= start:
                topic = self._channels.get(record.channel_id)
                if topic is not None and wanted(topic.name):
                    yield BagMessage(topic, record.log_time, record.data)

    def _read(self, start: int) -> Iterator[_Record]:
        """Yield records in the file's order; a chunk's messages in the order of their time."""
        with self._open() as file:
            size, end, record = self.path.stat().st_size, 0, None
            while not isinstance(record, Footer) and (found := self._next(file, start)) is not None:
                end, self.share = file.tell(), file.tell() / size
                for record in found:
                    self._learn(record)
                    yield record
            if not isinstance(record, Footer):
                self._note(f"at byte {end}: it ends there, without its index")

    def _merged(self, start: int) -> Iterator[_Record]:
        """Yield the messages of chunks that overlap in time; held are those that overlap."""
        held: list[tuple[int, int, Message]] = []
        order = itertools.count()
        with self._open() as file:
            for number, chunk in enumerate(self._unordered):
                while held and held[0][0] < chunk.message_start_time:
                    yield heapq.heappop(held)[2]
                file.seek(chunk.chunk_start_offset)
                for record in self._next(file, start) or ():
                    self._learn(record)
                    if isinstance(record, Message):
                        heapq.heappush(held, (record.log_time, next(order), record))
                self.share = (number + 1) / len(self._unordered)
        while held:
            yield heapq.heappop(held)[2]

    def _next(self, file: BinaryIO, start: int) -> list[_Record] | None:
        """Return what the next whole record holds, None where there is none."""
        offset = file.tell()
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, length = _HEAD.unpack(head)
        # At most 1 GiB: recorders write chunks of about 1 MiB.
        if length > min(self.path.stat().st_size - file.tell(), 1 << 30):
            return None
        content = file.read(length)
        try:
            stream = ReadDataStream(BytesIO(content))
            if kind == Opcode.CHUNK:
                return _chunk_records(Chunk.read(stream), start)
            if kind == Opcode.MESSAGE:
                return [Message.read(stream, length)]
            return [_SINGLE[kind](stream)] if kind in _SINGLE else []
        except _DAMAGE as error:
            self._note(f"at byte {offset}: {length} bytes are damaged ({reason_of(error)})")
            return []

    def _learn(self, record: _Record) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Metadata) and record.name == LOSS_RECORD:
            counts = {topic: int(text) for topic, text in record.metadata.items() if text.isdigit()}
            self.lost = Counter(counts)
        elif isinstance(record, Channel):
            self._channels[record.id] = self.topics[record.topic] = self._topic(record)

    def _topic(self, channel: Channel) -> TopicInfo:
        schema = self._schemas.get(channel.schema_id)
        readable = schema is not None and schema.encoding.endswith("msg")  # ros2msg, ros1msg
        kind = schema.name if schema else ""
        return TopicInfo(
            channel.topic,
            kind.replace("/", "/msg/") if kind.count("/") == 1 else kind,  # as ROS 1 writes it
            schema.data.decode(errors="replace") if schema and readable else "",
            channel.metadata.get("topic_type_hash", ""),
            topics.parse(channel.metadata.get("offered_qos_profiles", "")),
            channel.message_encoding,
        )


def _summary(file: BinaryIO) -> Summary | None:
    """Return the summary at a file's end, None where it is missing or has no statistics."""
    file.seek(0)
    try:
        summary = make_reader(file).get_summary()
    except (*_DAMAGE, OSError):  # it seeks a footer in front of a short file's beginning
        return None
    return summary if summary and summary.statistics and summary.chunk_indexes else None


def _chunk_records(chunk: Chunk, start: int) -> list[_Record]:
    records = breakup_chunk(_unpacked(chunk), validate_crc=True)
    rest: list[_Record] = [each for each in records if isinstance(each, Channel | Schema)]
    if chunk.message_end_time < start:
        return rest
    messages = [each for each in records if isinstance(each, Message)]
    return [*rest, *sorted(messages, key=lambda message: message.log_time)]


def _unpacked(chunk: Chunk) -> Chunk:
    """Return a chunk without its compression.

    Raises:
        ValueError: It is larger than it says, or than any chunk should be.
    """
    size = chunk.uncompressed_size
    # At most 256 MiB: recorders write chunks of about 1 MiB.
    if size > 1 << 28:
        raise ValueError(f"a chunk of {size} bytes")
    if chunk.compression == "zstd":
        packed: Any = zstandard.ZstdDecompressor().stream_reader(BytesIO(chunk.data))
    elif chunk.compression == "lz4":
        packed = lz4.frame.open(BytesIO(chunk.data))
    else:
        return chunk
    data = packed.read(size + 1)
    if len(data) != size:
        raise ValueError(f"a chunk of {size} bytes holds {len(data)}")
    return replace(chunk, compression="", data=data)
