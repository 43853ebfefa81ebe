"""Recordings written message by message."""

from __future__ import annotations

import weakref
from pathlib import Path

from arjuna_core.bags.topic import TopicInfo
from arjuna_core.bags.writer import BagFolder
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.qos import qos_of
from bringup.recording.convert import layout_of
from bringup.recording.message_definitions import installed_type
from rosbag2_py.options import (
    CompressionMode,
    CompressionOptions,
    ConverterOptions,
    StorageOptions,
    TopicMetadata,
)


class SequentialWriter:
    """Writes a recording, which ends with `close`, with the object or with the program.

    Raises:
        RuntimeError: The recording cannot be written, none is open, or a topic is unknown.
    """

    def __init__(self) -> None:
        self._compression = CompressionOptions()
        self._folder: BagFolder | None = None
        self._topics: dict[str, TopicInfo] = {}
        self._end: weakref.finalize[..., SequentialWriter] | None = None

    def open(
        self, storage_options: StorageOptions, converter_options: ConverterOptions | None = None
    ) -> None:
        self.close()
        compression = self._compression
        mode, threads = compression.compression_mode.name, compression.compression_threads
        self._folder = new_folder(storage_options, mode, threads)
        self._topics = {}
        self._end = weakref.finalize(self, self._folder.close)

    def close(self) -> None:
        """End the recording: write its index and metadata.yaml."""
        if self._end is not None:
            self._end()
        self._folder = self._end = None

    def _current(self) -> BagFolder:
        if self._folder is None:
            raise RuntimeError("Bag is not open. Call open() before writing.")
        return self._folder

    def create_topic(self, topic: TopicMetadata) -> None:
        """Add a topic, before its messages."""
        folder = self._current()
        offers = tuple(map(qos_of, topic.profiles()))
        definition, known = installed_type(topic.type)
        encoding = topic.serialization_format or "cdr"
        added = TopicInfo(
            *(topic.name, topic.type, definition, topic.type_description_hash or known),
            *(offers, encoding),
        )
        self._topics[topic.name] = added
        folder.add_topic(added)

    def remove_topic(self, topic: TopicMetadata) -> None:
        """Take no more messages of a topic."""
        self._current()
        self._topics.pop(topic.name, None)

    def write(
        self, topic_name: str, message: bytes, time_stamp: int, sequence_number: int = 0
    ) -> None:
        """Add a message by its bytes and its time [ns]."""
        folder = self._current()
        if topic_name not in self._topics:
            raise RuntimeError(
                f"Topic '{topic_name}' has not been created yet! Call 'create_topic' first."
            )
        folder.write(self._topics[topic_name], time_stamp, bytes(message), time_stamp)

    def split_bagfile(self) -> None:
        self._current().split()


class SequentialCompressionWriter(SequentialWriter):
    """Writes a recording whose files or messages are compressed."""

    def __init__(self, compression_options: CompressionOptions | None = None) -> None:
        super().__init__()
        self._compression = compression_options or CompressionOptions("zstd", CompressionMode.FILE)


def new_folder(given: StorageOptions, mode: str, threads: int) -> BagFolder:
    """Return the folder of a recording that begins.

    Args:
        mode: What is compressed.
        threads: How many compress; 0 for as many as there are cores.

    Raises:
        RuntimeError: It exists, or an option is not known.
    """
    try:
        layout = layout_of(
            *(given.storage_id, given.storage_preset_profile, given.storage_config_uri),
            *(mode, threads, given.custom_data),
            *(given.max_bagfile_size, given.max_bagfile_duration),
        )
        return BagFolder(Path(given.uri.removeprefix("file://")), *layout)
    except ArjunaError as error:
        raise RuntimeError(str(error)) from error
