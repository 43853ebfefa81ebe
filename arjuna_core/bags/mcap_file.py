"""Mcap files: read past damage, and as far as a file that was cut short goes."""

from __future__ import annotations

import heapq
import itertools
import os
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
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import breakup_chunk

from arjuna_core.bags import topic as topics
from arjuna_core.bags.metadata import BagFile, reason_of
from arjuna_core.bags.topic import MESSAGE_MAX, BagMessage, TopicInfo
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import open_file

LOSS_RECORD = "arjuna_lost_messages"
"""Name of the mcap metadata record that counts by topic the messages that never arrived."""

_MAGIC = b"\x89MCAP0\r\n"
_DAMAGE = (
    *(McapError, zstandard.ZstdError, ValueError, RuntimeError, KeyError, struct.error),
    *(EOFError, MemoryError, OverflowError),
)
_RECORD_MAX = MESSAGE_MAX + (1 << 20)  # [bytes]; recorders write chunks of about 1 MiB
_END = struct.Struct("<B8xQ12x8s")  # the footer: opcode, where the summary begins; magic
_HEAD = struct.Struct("<BQ")  # opcode and length of a record; mcap.dev/spec
_SINGLE: dict[int, Callable[..., Any]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.FOOTER: Footer.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
}
_Record = Schema | Channel | Message | Metadata | Footer | Statistics | ChunkIndex | MetadataIndex


class McapFile(BagFile):
    """The topics and messages of an mcap file."""

    KIND = "mcap"
    DAMAGE = ()  # it is noted where it stands, and read past

    def _take_index(self) -> str:
        self._channels: dict[int, TopicInfo] = {}
        self._schemas: dict[int, Schema] = {}
        self._unordered: list[ChunkIndex] = []
        with self._open() as file:
            summary = self._summary(file)
        if summary is None:
            self._count()
        else:
            self._take_summary(*summary)
        return ""

    def _summary(self, file: BinaryIO) -> tuple[Statistics, list[_Record]] | None:
        """Return the records at a file's end; None where they, or the statistics, are missing."""
        end = file.seek(0, os.SEEK_END) - _END.size
        file.seek(max(0, end))
        kind, start, magic = _END.unpack(file.read().rjust(_END.size))
        # A recording of 100 GB has some 10 MB of them.
        if kind != Opcode.FOOTER or magic != _MAGIC or not 0 < end - start <= _RECORD_MAX:
            return None
        file.seek(start)
        found: list[_Record] = []
        while file.tell() < end:
            records = self._next(file, 0)
            if records is None or self.problems or any(isinstance(r, Message) for r in records):
                self.problems = []  # they are noted as all is read
                return None
            found += records
        statistics = next((each for each in found if isinstance(each, Statistics)), None)
        is_indexed = any(isinstance(each, ChunkIndex) for each in found)
        return (statistics, found) if statistics and is_indexed else None

    def _open(self) -> BinaryIO:
        file = open_file(self.path)
        if file.read(len(_MAGIC)) == _MAGIC:
            return file
        file.close()
        raise InputFileError(self.path, "is no mcap recording: it does not begin as one")

    def _take_summary(self, statistics: Statistics, records: list[_Record]) -> None:
        for record in sorted(records, key=lambda each: isinstance(each, Channel)):
            self._learn(record)
        for key, count in statistics.channel_message_counts.items():
            if key in self._channels:
                self.entry.counts[self._channels[key].name] += count
        self.entry.start = statistics.message_start_time
        self.entry.end = statistics.message_end_time
        known = {each.chunk_start_offset: each for each in records if isinstance(each, ChunkIndex)}
        chunks = [known[offset] for offset in sorted(known)]
        if any(b.message_start_time < a.message_end_time for a, b in itertools.pairwise(chunks)):
            self._unordered = sorted(chunks, key=lambda chunk: chunk.message_start_time)
        with self._open() as file:
            for record in records:
                if isinstance(record, MetadataIndex):
                    for each in self._at(file, record.offset):
                        self._learn(each)

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
            size, end, record = os.fstat(file.fileno()).st_size, 0, None
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
        size, most = 0, 1 << 25  # [bytes]
        order = itertools.count()
        with self._open() as file:
            for number, chunk in enumerate(self._unordered):
                while held and (held[0][0] < chunk.message_start_time or size > most):
                    if held[0][0] >= chunk.message_start_time:
                        self._note(f"more than {most} bytes overlap in time: not all are in order")
                    size -= len(held[0][2].data)
                    yield heapq.heappop(held)[2]
                for record in self._at(file, chunk.chunk_start_offset, start):
                    self._learn(record)
                    if isinstance(record, Message):
                        heapq.heappush(held, (record.log_time, next(order), record))
                        size += len(record.data)
                self.share = (number + 1) / len(self._unordered)
        while held:
            yield heapq.heappop(held)[2]

    def _at(self, file: BinaryIO, offset: int, start: int = 0) -> list[_Record]:
        """Return what the record at an offset holds, which may lie anywhere."""
        if not 0 <= offset < os.fstat(file.fileno()).st_size:
            self._note(f"its index names byte {offset}, which it does not have")
            return []
        file.seek(offset)
        return self._next(file, start) or []

    def _next(self, file: BinaryIO, start: int) -> list[_Record] | None:
        """Return what the next whole record holds, None where there is none."""
        offset = file.tell()
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, length = _HEAD.unpack(head)
        # No record has the kind 0; holes in a file read as such.
        if kind == 0 or length > os.fstat(file.fileno()).st_size - file.tell():
            return None
        if length > _RECORD_MAX:
            file.seek(length, os.SEEK_CUR)
            self._note(f"at byte {offset}: a record of {length} bytes; read are {_RECORD_MAX}")
            return []
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
    if size > _RECORD_MAX:
        raise ValueError(f"a chunk of {size} bytes; read are {_RECORD_MAX}")
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
