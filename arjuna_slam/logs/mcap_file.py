"""Mcap recordings as SLAM reads them: what their topics carry, and their messages."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mcap.records import Channel, Message, Schema

from arjuna_slam.logs.mcap_records import McapRecords

_NAMED = 3  # damages


class McapFile:
    """An mcap file.

    Args:
        path: The file.

    Raises:
        InputFileError: It cannot be read or does not begin as one.
    """

    def __init__(self, path: Path) -> None:
        self._records = McapRecords(path)
        self._summary = self._records.summary()

    def channels(self) -> dict[str, tuple[str, str, str]]:
        """Return type, encoding and definition of each topic: by the summary, else by all of it."""
        summary = self._summary
        if summary is not None and summary.channels:
            return _channels(summary.schemas, list(summary.channels.values()))
        schemas: dict[int, Schema] = {}
        channels: list[Channel] = []
        for record in self._records.read():
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels.append(record)
        return _channels(schemas, channels)

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes, float]]:
        """Yield topic, bytes and the share (0..1) of the file that has been read.

        Args:
            topics: The topics.

        Raises:
            ValueError: Something of it is missing; raised when the rest has been read.
        """
        known = self._summary.channels.values() if self._summary is not None else ()
        names = {channel.id: channel.topic for channel in known}  # its own chunk may be damaged
        for record in self._records.read():
            if isinstance(record, Channel):
                names[record.id] = record.topic
            elif isinstance(record, Message) and names.get(record.channel_id) in topics:
                yield names[record.channel_id], record.data, self._records.share
        if self._records.damages:
            raise ValueError("; ".join(map(str, self._records.damages[:_NAMED])))


def _channels(
    schemas: dict[int, Schema], channels: list[Channel]
) -> dict[str, tuple[str, str, str]]:
    found = {}
    for channel in channels:
        schema = schemas.get(channel.schema_id)
        kind = "" if schema is None else schema.name
        text = ""
        if schema is not None and schema.encoding.endswith("msg"):
            text = schema.data.decode("utf-8", "replace")
        found[channel.topic] = kind, channel.message_encoding, text
    return found
