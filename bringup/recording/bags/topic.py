"""What a recording says of a topic: its type, and its publishers' QoS as rosbag2 keeps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import yaml

_FOREVER = {"sec": 9223372036, "nsec": 854775807}
_LATCHED_DEPTH, _DEPTH = 1, 100  # where a recording does not say; enough for a burst
_LATCHED = ("transient_local", 1)  # as text from rosbag2's version 9 on, before as rmw's numbers
_BEST_EFFORT = ("best_effort", 2)


@dataclass(frozen=True)
class TopicQos:
    """What matters of a publisher's QoS.

    Attributes:
        reliable: Whether what is lost is sent again.
        latched: Whether who subscribes late gets the last messages (transient local).
        depth: How many messages are kept; 0 where that is not known, as discovery does not say.
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
    """What a recording says of a topic.

    Attributes:
        name: Its name.
        type_name: Its type, such as `nav_msgs/msg/Path`.
        definition: The type's definition and those of all types it needs (`ros2msg`).
        type_hash: The type's RIHS01 hash, "" if not known.
        offers: QoS of its publishers.
        encoding: Encoding of its messages.
    """

    name: str
    type_name: str
    definition: str = ""
    type_hash: str = ""
    offers: tuple[TopicQos, ...] = ()
    encoding: str = "cdr"


def dump(profiles: Iterable[TopicQos]) -> str:
    """Return the profiles of a topic's publishers as a recording keeps them."""
    return str(yaml.safe_dump([each.to_rosbag2() for each in profiles], sort_keys=False))


def parse(profiles: str | Sequence[Any]) -> tuple[TopicQos, ...]:
    """Return the profiles that a recording holds; what cannot be read is left out.

    Args:
        profiles: Text as `dump` makes it, or the list that such a text stands for.
    """
    if isinstance(profiles, str):
        try:
            profiles = yaml.safe_load(profiles) or []
        except yaml.YAMLError:
            return ()
    if not isinstance(profiles, Sequence):
        return ()
    return tuple(_read(each) for each in profiles if isinstance(each, Mapping))


def _read(profile: Mapping[str, Any]) -> TopicQos:
    depth = profile.get("depth")
    return TopicQos(
        reliable=profile.get("reliability") not in _BEST_EFFORT,
        latched=profile.get("durability") in _LATCHED,
        depth=depth if isinstance(depth, int) and 0 < depth < 100_000 else 0,
    )


def request_for(offers: Sequence[TopicQos]) -> TopicQos:
    """Return what a subscription may ask for so that every publisher's offer matches."""
    return TopicQos(
        reliable=all(each.reliable for each in offers),
        latched=bool(offers) and all(each.latched for each in offers),
    )


def offer_for(recorded: Sequence[TopicQos], publishers: int = 1) -> TopicQos:
    """Return what one publisher offers that stands for all those that were recorded.

    Args:
        recorded: Their profiles; none where the recording says nothing.
        publishers: How many messages of a latched topic may be current at once: each static
            transform's publisher has its own.
    """
    latched = any(each.latched for each in recorded)
    usual = max(_LATCHED_DEPTH, publishers) if latched else _DEPTH
    return TopicQos(
        reliable=not recorded or any(each.reliable for each in recorded),
        latched=latched,
        depth=max([usual, *(each.depth for each in recorded)]),
    )


class BagMessage(NamedTuple):
    """One recorded message.

    Attributes:
        topic: Its topic.
        time: When it was received [ns].
        data: Its bytes.
    """

    topic: TopicInfo
    time: int
    data: bytes
