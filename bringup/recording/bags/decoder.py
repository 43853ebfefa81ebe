"""Messages of a recording by the definitions that it carries, with no ROS installed."""

from __future__ import annotations

from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from arjuna_core.errors import ArjunaError
from bringup.recording.bags.topic import TopicInfo

_LONGEST = 1 << 28  # elements of a sequence that are believed


class DecodeError(ArjunaError):
    """A message cannot be read."""


class Decoder:
    """Reads messages of any type; definitions of Jazzy stand in where a recording has none."""

    def __init__(self) -> None:
        self._store = get_typestore(Stores.EMPTY)
        self._jazzy = get_typestore(Stores.ROS2_JAZZY)
        for store in (self._store, self._jazzy):
            store.max_sequence_length = _LONGEST

    def decode(self, topic: TopicInfo, data: bytes) -> Any:
        """Return a message, with the fields of its type as attributes.

        Args:
            topic: Its topic.
            data: Its bytes.

        Raises:
            DecodeError: Its type is not known, or the bytes are none of it.
        """
        name = topic.type_name
        try:
            if topic.definition and name not in self._store.types:
                found = get_types_from_msg(topic.definition, name)
                known = self._store.types
                self._store.register({key: each for key, each in found.items() if key not in known})
            store = self._store if name in self._store.types else self._jazzy
            return store.deserialize_cdr(data, name)
        except (SerdeError, TypesysError, KeyError, ValueError) as error:
            raise DecodeError(f"{name}: {error}") from error
