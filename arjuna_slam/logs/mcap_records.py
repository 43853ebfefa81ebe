"""Records of an mcap file in its order, past damage, as far as a file that was cut short goes.

All that reads recordings reads mcap by these: SLAM's logs, and playing, viewing and mending them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Footer, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary

from arjuna_core.errors import InputFileError

MAGIC = b"\x89MCAP0\r\n"
DAMAGE = (
    *(McapError, zstandard.ZstdError, ValueError, RuntimeError, KeyError, struct.error),
    *(EOFError, MemoryError, OverflowError),
)
_LONGEST = 1 << 30  # bytes of a record that are believed
_CHUNK_MAX = 1 << 28  # bytes; recorders write chunks of about 1 MiB
_HEAD = struct.Struct("<BQ")
_SINGLE: dict[int, Callable[..., Any]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.FOOTER: Footer.read,
}
Record = Schema | Channel | Message | Metadata | Footer


@dataclass(frozen=True)
class Damage:
    """Something that a file lacks.

    Attributes:
        offset: Where [bytes].
        what: What is wrong there.
    """

    offset: int
    what: str

    def __str__(self) -> str:
        """Say where, and what."""
        return f"at byte {self.offset}: {self.what}"


class McapRecords:
    """The records of a file: schemas, channels, messages, metadata and the footer.

    Args:
        path: The file.

    Attributes:
        damages: What was found missing, complete once the records have been read to the end.
        whole: The length of the part that holds whole records [bytes].
        share: Share (0..1) of the file that has been read.

    Raises:
        InputFileError: It cannot be read or does not begin as an mcap.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.damages: list[Damage] = []
        self.whole = 0
        self.share = 0.0
        with self._open():
            pass

    def _open(self) -> BinaryIO:
        try:
            file = self._path.open("rb")
        except OSError as error:
            problem = f"cannot be read: {error.strerror or error}"
            raise InputFileError(self._path, problem) from error
        if file.read(len(MAGIC)) == MAGIC:
            return file
        file.close()
        raise InputFileError(self._path, "is no mcap recording: it does not begin as one")

    def summary(self) -> Summary | None:
        """Return what its end says of it, None where that is missing."""
        try:
            with self._path.open("rb") as file:
                return make_reader(file).get_summary()
        except (*DAMAGE, OSError):  # it seeks a footer in front of a short file's beginning
            return None

    def read(self, start: int = 0) -> Iterator[Record]:
        """Yield the records; a chunk's messages in the order of their time.

        Args:
            start: Chunks whose messages are all older may be passed over [ns].
        """
        self.damages.clear()
        with self._open() as file:
            size = self._path.stat().st_size
            footer = False
            while not footer and (found := self._next(file, size)) is not None:
                self.whole, self.share = file.tell(), file.tell() / size
                for record in self._records(*found, start):
                    footer = isinstance(record, Footer)
                    yield record
            if not footer:
                self._note(self.whole, "it ends there, without its index")

    def _note(self, offset: int, what: str) -> None:
        self.damages.append(Damage(offset, what))

    def _next(self, file: BinaryIO, size: int) -> tuple[int, int, bytes] | None:
        """Return offset, kind and content of the next whole record, None where there is none."""
        offset = file.tell()
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, length = _HEAD.unpack(head)
        if length > min(size - file.tell(), _LONGEST):
            return None
        return offset, kind, file.read(length)

    def _records(self, offset: int, kind: int, content: bytes, start: int) -> list[Record]:
        try:
            stream = ReadDataStream(BytesIO(content))
            if kind == Opcode.CHUNK:
                return _messages(Chunk.read(stream), start)
            if kind == Opcode.MESSAGE:
                return [Message.read(stream, len(content))]
            return [_SINGLE[kind](stream)] if kind in _SINGLE else []
        except DAMAGE as error:
            why = str(error) or type(error).__name__
            self._note(offset, f"{len(content)} bytes are damaged ({why})")
            return []


def _messages(chunk: Chunk, start: int) -> list[Record]:
    records = breakup_chunk(_unpacked(chunk), validate_crc=True)
    rest: list[Record] = [each for each in records if isinstance(each, Channel | Schema)]
    if chunk.message_end_time < start:
        return rest
    messages = [each for each in records if isinstance(each, Message)]
    messages.sort(key=lambda message: message.log_time)
    return [*rest, *messages]


def _unpacked(chunk: Chunk) -> Chunk:
    """Return a chunk without its compression.

    Raises:
        ValueError: It is larger than it says, or than any chunk should be.
    """
    if chunk.uncompressed_size > _CHUNK_MAX:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes")
    if chunk.compression == "zstd":
        packed: Any = zstandard.ZstdDecompressor().stream_reader(BytesIO(chunk.data))
    elif chunk.compression == "lz4":
        packed = lz4.frame.open(BytesIO(chunk.data))
    else:
        return chunk
    data = packed.read(chunk.uncompressed_size + 1)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes holds {len(data)}")
    return replace(chunk, compression="", data=data)
