"""Topics of a recording: their types, and their publishers' QoS as rosbag2 stores it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import yaml

from arjuna_core.files.yaml_file import plain

ROS1, ROS2 = "ros1", "cdr"
"""Encodings of messages that can be decoded."""

_FOREVER = {"sec": 9223372036, "nsec": 854775807}  # rmw_dds_common's infinite duration
_LATCHED = ("transient_local", 1)  # as text from rosbag2's version 9 on, before as rmw's numbers
_BEST_EFFORT = ("best_effort", 2)


@dataclass(frozen=True)
class TopicQos:
    """The parts of a publisher's QoS that decide which subscriptions match.

    Attributes:
        reliable: Whether lost messages are sent again.
        latched: Whether late subscribers get the last messages (transient local).
        depth: How many messages are kept; 0 where that is unknown, as discovery omits it.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 0

    def to_rosbag2(self) -> dict[str, Any]:
        """Return the profile as rosbag2's version 9 writes it."""
        return {
            "history": "keep_last" if self.depth else "unknown",
            "depth": self.depth,
            "reliability": "reliable" if self.reliable else "best_effort",
            "durability": "transient_local" if self.latched else "volatile",
            "deadline": _FOREVER,
            "lifespan": _FOREVER,
            "liveliness": "automatic",
            "liveliness_lease_duration": _FOREVER,
            "avoid_ros_namespace_conventions": False,
        }


@dataclass(frozen=True)
class TopicInfo:
    """A topic of a recording.

    Attributes:
        definition: The definitions of the type and of all types it needs (`ros2msg`).
        type_hash: The type's RIHS01 hash, "" if unknown.
    """

    name: str
    type_name: str
    definition: str = ""
    type_hash: str = ""
    offers: tuple[TopicQos, ...] = ()
    encoding: str = ROS2


class PlainDumper(yaml.SafeDumper):
    """Writes in the given order and repeats what occurs twice: rosbag2 reads no anchors here."""

    def __init__(self, stream: Any, **options: Any) -> None:
        super().__init__(stream, **{**options, "sort_keys": False})

    def ignore_aliases(self, data: Any) -> bool:
        """Return that everything is written out."""
        return True


MESSAGE_MAX = 1 << 26
"""How large a message may be [bytes]: a map of 8000 x 8000 cells."""


class BagMessage(NamedTuple):
    """A recorded message.

    Attributes:
        time: When it was received [ns].
    """

    topic: TopicInfo
    time: int
    data: bytes


def dump(profiles: Iterable[TopicQos]) -> str:
    """Return the profiles of a topic's publishers as text of a recording."""
    return str(yaml.dump([each.to_rosbag2() for each in profiles], Dumper=PlainDumper))


def parse(profiles: str) -> tuple[TopicQos, ...]:
    """Return the profiles in a recording's text; unreadable ones are left out."""
    try:
        found = plain(profiles)
    except yaml.YAMLError:
        return ()
    if not isinstance(found, list):
        return ()
    return tuple(_read(each) for each in found if isinstance(each, Mapping))


def _read(profile: Mapping[str, Any]) -> TopicQos:
    depth = profile.get("depth")
    return TopicQos(
        reliable=profile.get("reliability") not in _BEST_EFFORT,
        latched=profile.get("durability") in _LATCHED,
        depth=depth if isinstance(depth, int) and 0 < depth < 100_000 else 0,
    )


def request_for(offers: Sequence[TopicQos]) -> TopicQos:
    """Return the strongest request of a subscription that every publisher's offer matches."""
    return TopicQos(
        reliable=all(each.reliable for each in offers),
        latched=bool(offers) and all(each.latched for each in offers),
    )


def offer_for(recorded: Sequence[TopicQos], publishers: int = 1, depth: int = 100) -> TopicQos:
    """Return the offer of one publisher that stands for all recorded ones.

    Args:
        recorded: Their profiles; none where the recording has none.
        publishers: How many messages of a latched topic may be current at once: each static
            transform's publisher has its own.
        depth: Messages kept of a topic that is not latched: enough for a burst.
    """
    latched = any(each.latched for each in recorded)
    return TopicQos(
        reliable=not recorded or any(each.reliable for each in recorded),
        latched=latched,
        depth=max([publishers if latched else depth, *(each.depth for each in recorded)]),
    )
