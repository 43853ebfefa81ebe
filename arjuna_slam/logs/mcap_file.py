"""Messages of mcap files, one by one; a file that was cut short is read as far as it goes."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import yaml
import zstandard
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader

from arjuna_core.errors import InputFileError

_DAMAGE = (
    *(McapError, zstandard.ZstdError, ValueError, RuntimeError, KeyError, struct.error),
    *(EOFError, MemoryError),
)


class McapFiles:
    """The mcap files of one recording.

    Args:
        path: An mcap file, or a rosbag2 folder with such files.

    Attributes:
        progress: Share (0..1) of the bytes read.
        problems: What was passed over.

    Raises:
        InputFileError: It is no recording in mcap storage.
    """

    def __init__(self, path: Path) -> None:
        self.progress = 0.0
        self.problems: list[str] = []
        self._files = _files(path)

    def channels(self) -> dict[str, tuple[str, str]]:
        """Return type and encoding of each topic.

        Raises:
            InputFileError: A file is no mcap.
        """
        found: dict[str, tuple[str, str]] = {}
        for path in self._files:
            found.update(_indexed(path) or self._scanned(path))
        return found

    def messages(self, topics: set[str]) -> Iterator[tuple[str, bytes]]:
        """Yield topic and bytes of each message of some topics, in the order of the files.

        Args:
            topics: The topics.
        """
        self.progress = 0.0
        for number, path in enumerate(self._files):
            names: dict[int, str] = {}
            for record, share in self._records(path):
                self.progress = (number + share) / len(self._files)
                if isinstance(record, Channel):
                    names[record.id] = record.topic
                elif isinstance(record, Message) and names.get(record.channel_id) in topics:
                    yield names[record.channel_id], record.data

    def _scanned(self, path: Path) -> dict[str, tuple[str, str]]:
        """Return the channels of a file without a summary."""
        types: dict[int, str] = {}
        found: dict[str, tuple[str, str]] = {}
        for record, _ in self._records(path):
            if isinstance(record, Schema):
                types[record.id] = record.name
            elif isinstance(record, Channel):
                found[record.topic] = types.get(record.schema_id, ""), record.message_encoding
        return found

    def _records(self, path: Path) -> Iterator[tuple[object, float]]:
        size = path.stat().st_size
        with path.open("rb") as file:
            try:
                for record in StreamReader(file, record_size_limit=size).records:
                    yield record, file.tell() / size
            except _DAMAGE as error:
                where = f"{path.name}: damaged or cut short at {100.0 * file.tell() / size:.0f} %"
                note = f"{where} ({str(error) or type(error).__name__}); read up to there"
                if note not in self.problems:
                    self.problems.append(note)


def _indexed(path: Path) -> dict[str, tuple[str, str]] | None:
    """Return the channels of a file's summary, or None where it has none."""
    try:
        with path.open("rb") as file:
            if file.read(8) != b"\x89MCAP0\r\n":
                raise InputFileError(path, "is no mcap recording: it does not begin as one")
            file.seek(0)
            summary = make_reader(file).get_summary()
    except OSError as error:
        raise InputFileError(path, f"cannot be read: {error.strerror or error}") from error
    except _DAMAGE:
        return None
    if summary is None or not summary.channels:
        return None
    schemas = {key: schema.name for key, schema in summary.schemas.items()}
    return {
        channel.topic: (schemas.get(channel.schema_id, ""), channel.message_encoding)
        for channel in summary.channels.values()
    }


def _files(path: Path) -> list[Path]:
    """Return the mcap files of a file or of a rosbag2 folder, in the order of its metadata."""
    if not path.is_dir():
        return [path]
    metadata = path / "metadata.yaml"
    found = _listed(metadata) if metadata.exists() else sorted(path.glob("*.mcap"))
    if not found:
        raise InputFileError(path, "is a folder without mcap files")
    for file in found:
        if file.suffix != ".mcap" or not file.is_file():
            raise InputFileError(file, "is no mcap file; valid: recordings in mcap storage")
    return found


def _listed(metadata: Path) -> list[Path]:
    try:
        text = yaml.safe_load(metadata.read_text(encoding="utf-8"))
        names = text["rosbag2_bagfile_information"]["relative_file_paths"]
        return [metadata.parent / Path(name).name for name in names]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise InputFileError(metadata, f"is no metadata of rosbag2: {error}") from error
