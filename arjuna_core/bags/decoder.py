"""Messages of a recording decoded by the definitions that it carries; no ROS installed."""

from __future__ import annotations

from functools import cache
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from arjuna_core.bags.topic import ROS1, ROS2, TopicInfo
from arjuna_core.errors import ArjunaError

TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
"""Types of transforms, that of ROS 1 last."""

_SEQUENCE_MAX = 1 << 28  # elements


class DecodeError(ArjunaError, ValueError):
    """A message cannot be decoded."""


@cache
def _known(encoding: str) -> Any:
    """Return ROS's own definitions; those of common messages are the same in all its releases."""
    store = get_typestore(Stores.ROS2_JAZZY if encoding == ROS2 else Stores.ROS1_NOETIC)
    store.max_sequence_length = _SEQUENCE_MAX
    for kind in TRANSFORMS:
        if kind not in store.fielddefs:
            store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", kind))
    return store


def _defined(topic: TopicInfo) -> dict[str, Any]:
    """Return the types that a recording defines for a topic; none where it cannot be read."""
    # A definition of more than 100 000 characters is skipped.
    if not 0 < len(topic.definition.strip()) <= 100_000:
        return {}
    try:
        found = get_types_from_msg(topic.definition, topic.type_name)
    except (TypesysError, ValueError, RecursionError):
        return {}
    # a service's events are a type that rosbags has no name for
    return {name.replace("/srv/msg/", "/srv/"): each for name, each in found.items()}


def is_standard(topic: TopicInfo) -> bool:
    """Return whether a recording's definition of a topic's type, if any, is that of ROS."""
    found, known = _defined(topic), _known(topic.encoding).fielddefs
    return all(found[name][1] == known[name][1] for name in found.keys() & known.keys())


class Decoder:
    """Decodes messages of any type; ROS's own definitions stand in for missing ones."""

    def __init__(self) -> None:
        self._stores = {each: get_typestore(Stores.EMPTY) for each in (ROS1, ROS2)}
        for store in self._stores.values():
            store.max_sequence_length = _SEQUENCE_MAX
        self._seen: set[TopicInfo] = set()

    def decode(self, topic: TopicInfo, data: bytes) -> Any:
        """Return a message, with the fields of its type as attributes.

        Raises:
            DecodeError: Its type or encoding is unknown, or the bytes are no message of it.
        """
        name = topic.type_name
        store = self._stores.get(topic.encoding)
        if store is None:
            raise DecodeError(
                f"{topic.name} is encoded as '{topic.encoding}'; valid: {ROS2}, {ROS1}"
            )
        try:
            if topic not in self._seen:
                self._seen.add(topic)
                found = _defined(topic)
                store.register({k: each for k, each in found.items() if k not in store.types})
            if name not in store.types:
                store = _known(topic.encoding)
            if topic.encoding == ROS1:
                return store.deserialize_ros1(data, name)
            return store.deserialize_cdr(data, name)
        except (SerdeError, TypesysError, KeyError, ValueError, IndexError) as error:
            raise DecodeError(f"{name}: {error}") from error
