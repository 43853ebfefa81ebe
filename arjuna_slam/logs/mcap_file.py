"""Mcap recordings, record by record, so that one without its end is read as far as it goes."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import zstandard
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

_CHUNK_MAX = 1 << 28  # bytes; recorders write chunks of about 1 MiB

DAMAGE = (
    *(McapError, zstandard.ZstdError, struct.error, ValueError, RuntimeError, KeyError),
    *(EOFError, MemoryError, OverflowError),
)
"""What reading a damaged file raises."""


class McapFile:
    """An mcap file.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def channels(self) -> dict[str, tuple[str, str, str]]:
        """Return type, encoding and definition of each topic: by the summary, else by all of it.

        Raises:
            ValueError: It does not begin as an mcap file.
        """
        with self._path.open("rb") as file:
            if file.read(8) != b"\x89MCAP0\r\n":
                raise ValueError("it does not begin as one")
            file.seek(0)
            summary = _summary(file)
        if summary is not None and summary.channels:
            return _channels(summary.schemas, list(summary.channels.values()))
        schemas: dict[int, Any] = {}
        channels: list[Any] = []
        with suppress(*DAMAGE):  # said when the messages are read
            for record, _ in self._records():
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels.append(record)
        return _channels(schemas, channels)

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        """Yield topic, bytes and the share (0..1) of the file that has been read.

        Args:
            topics: The topics.
        """
        names: dict[int, str] = {}
        for record, share in self._records():
            if isinstance(record, Channel):
                names[record.id] = record.topic
            elif isinstance(record, Message) and names.get(record.channel_id) in topics:
                yield names[record.channel_id], record.data, share

    def _records(self) -> Iterator[tuple[object, float]]:
        size = self._path.stat().st_size
        with self._path.open("rb") as file:
            for record in StreamReader(file, emit_chunks=True, record_size_limit=size).records:
                share = file.tell() / size
                if isinstance(record, Chunk):
                    yield from ((inner, share) for inner in breakup_chunk(_inflated(record)))
                else:
                    yield record, share


def _summary(file: BinaryIO) -> Any:
    """Return the summary at the end of a file, or None where it is missing."""
    try:
        return make_reader(file).get_summary()
    except DAMAGE:
        return None


def _channels(schemas: dict[int, Any], channels: list[Any]) -> dict[str, tuple[str, str, str]]:
    found = {}
    for channel in channels:
        schema = schemas.get(channel.schema_id)
        kind = "" if schema is None else schema.name
        text = ""
        if schema is not None and schema.encoding.endswith("msg"):
            text = schema.data.decode("utf-8", "replace")
        found[channel.topic] = kind, channel.message_encoding, text
    return found


def _inflated(chunk: Any) -> Any:
    """Return a chunk without its compression.

    Raises:
        ValueError: It is larger than it says, or than any chunk should be.
    """
    if chunk.compression == "zstd":
        packed: Any = zstandard.ZstdDecompressor().stream_reader(BytesIO(chunk.data))
    elif chunk.compression == "lz4":
        packed = lz4.frame.open(BytesIO(chunk.data))
    else:
        return chunk
    limit = min(chunk.uncompressed_size, _CHUNK_MAX)
    data = packed.read(limit + 1)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes holds {len(data)}")
    return replace(chunk, compression="", data=data)
