"""Bags of ROS 1, also those that were cut short and have no index.

Source: the bag format 2.0, wiki.ros.org/Bags/Format/2.0.
"""

from __future__ import annotations

import bz2
import struct
from collections.abc import Callable, Iterator
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import BinaryIO, cast

import lz4.frame
from rosbags.rosbag1 import Reader, ReaderError
from rosbags.rosbag1.reader import (
    Chunk,
    ChunkInfo,
    Header,
    IndexData,
    RecordType,
    read_bytes,
    read_uint32,
)

from arjuna_core.bags.metadata import BagFile, reason_of
from arjuna_core.bags.topic import MESSAGE_MAX, ROS1, BagMessage, TopicInfo
from arjuna_core.files.input_file import open_file

_DAMAGE = (
    *(ReaderError, OSError, ValueError, RuntimeError, KeyError, IndexError, AssertionError),
    *(struct.error, EOFError, MemoryError, OverflowError),
)
_CHUNK_MAX = MESSAGE_MAX + (1 << 20)  # [bytes]; rosbag writes chunks of about 768 KiB


class Ros1File(BagFile):
    """The topics and messages of a ROS 1 bag."""

    KIND = "bag"
    DAMAGE = _DAMAGE

    def _take_index(self) -> str:
        self._reader = _Reader(cast("Path", _Source(self.path)))
        with self._reader as bag:
            self.topics = {
                c.topic: TopicInfo(c.topic, c.msgtype, c.msgdef.data, encoding=ROS1)
                for c in bag.connections
            }
            for c in bag.connections:
                for index in bag.indexes[c.id]:
                    self.entry.count(c.topic, index.time)
        return self._reader.damage

    def _messages(self, takes: Callable[[str], bool], start: int) -> Iterator[BagMessage]:
        with self._reader as bag:
            wanted = [c for c in bag.connections if takes(c.topic)]
            if not wanted:  # rosbags takes none for all
                return
            for connection, time, data in bag.messages(wanted, start or None):
                self.share = (time - self.entry.start) / max(bag.duration, 1)
                yield BagMessage(self.topics[connection.topic], time, data)


class _Records(BufferedReader):
    """A bag's file, of which nothing larger than any record is read at once."""

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > _CHUNK_MAX:
            raise ReaderError(f"a record of {size} bytes; read are {_CHUNK_MAX}")
        return super().read(size)

    def readline(self, size: int | None = -1, /) -> bytes:
        return super().readline(64)  # the line that a bag begins with


class _Source:
    """A bag's path, as the library opens it."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def exists(self) -> bool:
        return True

    def open(self, mode: str) -> BinaryIO:
        return _Records(open_file(self._path).detach())


class _Reader(Reader):
    """Reads a bag by its index, or by one made of its chunks where it has none.

    Attributes:
        damage: Why the index had to be made, empty where it had not.
    """

    damage = ""

    def open(self) -> None:
        try:
            super().open()
        except _DAMAGE as error:
            self.damage = reason_of(error)
            self.bio = self.path.open("rb")
            self.indexes, self.chunk_infos = {}, []
            if self.bio.readline() != b"#ROSBAG V2.0\n":
                self.close()
                raise
            self._scan()
            if not self.connections:
                self.close()
                raise

    def read_chunk(self) -> Chunk:
        assert self.bio
        start = self.bio.tell()
        size = Header.read(self.bio, RecordType.CHUNK).get_uint32("size")
        self.bio.seek(start)
        chunk = super().read_chunk()
        decompressor = chunk.decompressor
        bounded = {bz2.decompress: _bz2, lz4.frame.decompress: _lz4}.get(decompressor)
        return chunk if bounded is None else chunk._replace(decompressor=lambda d: bounded(d, size))

    def _scan(self) -> None:
        """Index the chunks up to the first that is damaged or missing."""
        file = self.bio
        assert file
        while True:
            position = file.tell()
            try:
                kind = Header.read(file).get_uint8("op")
                if kind == RecordType.CHUNK:
                    file.seek(position)
                    self.chunks[position] = chunk = self.read_chunk()
                    file.seek(chunk.datapos)
                    content = chunk.decompressor(read_bytes(file, chunk.datasize))
                    self._scan_chunk(position, content)
                else:
                    read_bytes(file, read_uint32(file))
            except _DAMAGE:
                break
        times = [each.time for index in self.indexes.values() for each in index]
        if times:
            self.chunk_infos = [ChunkInfo(0, min(times), max(times) + 1, {})]
        self.indexes = {c.id: sorted(self.indexes.get(c.id, [])) for c in self.connections}

    def _scan_chunk(self, position: int, content: bytes) -> None:
        outer, self.bio = self.bio, BytesIO(content)
        try:
            while (offset := self.bio.tell()) < len(content):
                header = Header.read(self.bio)
                if header.get_uint8("op") == RecordType.CONNECTION:
                    self.bio.seek(offset)
                    connection = self.read_connection()
                    if connection.id not in {each.id for each in self.connections}:
                        self.connections.append(connection)
                    continue
                read_bytes(self.bio, read_uint32(self.bio))
                entry = IndexData(header.get_time("time"), position, offset)
                self.indexes.setdefault(header.get_uint32("conn"), []).append(entry)
        finally:
            self.bio = outer


def _bz2(data: bytes, size: int) -> bytes:
    return _checked(bz2.BZ2Decompressor().decompress(data, min(size, _CHUNK_MAX) + 1), size)


def _lz4(data: bytes, size: int) -> bytes:
    return _checked(lz4.frame.open(BytesIO(data)).read(min(size, _CHUNK_MAX) + 1), size)


def _checked(data: bytes, size: int) -> bytes:
    if len(data) != size:
        raise ReaderError(f"a chunk of {size} bytes holds {len(data)}")
    return data
