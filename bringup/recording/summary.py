"""Summary of a recording and of its gaps: the lines of `ros2 bag info` and some of our own."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from datetime import datetime

from arjuna_core.bags.decoder import Decoder
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.timing import NANOSECONDS
from bringup.recording.selection import EVENTS, is_service

_INDENT = " " * 19
_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")


def lines(bag: Bag, verbose: bool = False) -> Iterator[str]:
    """Yield the lines of `ros2 bag info`; verbose counts requests and responses, and reads all."""
    counts = bag.counts
    names = [file.name for file in bag.files]
    events = {name for name, topic in bag.topics.items() if is_service(name, topic.type_name)}
    yield _row("Files", names[0])
    yield from (f"{_INDENT}{name}" for name in names[1:])
    yield _row("Bag size", _size(bag.size))
    yield _row("Storage id", bag.storage)
    yield _row("ROS Distro", bag.distribution)
    yield _row("Duration", f"{(bag.end - bag.start) / NANOSECONDS:.9f}s")
    yield _row("Start", _time(bag.start))
    yield _row("End", _time(bag.end))
    yield _row("Messages", str(counts.total()))
    yield from _rows(
        "Topic information",
        [
            f"Topic: {name} | Type: {topic.type_name} | Count: {counts[name]} | {_format(topic)}"
            for name, topic in sorted(bag.topics.items())
            if name not in events
        ],
    )
    yield _row("Service", str(len(events)))
    amounts = _requests(bag, events) if verbose else {}
    services = []
    for name in sorted(events):
        topic = bag.topics[name]
        kind = topic.type_name.removesuffix("_Event")
        amount = amounts.get(name, f"Event Count: {counts[name]}")
        text = f"Service: {name.removesuffix(EVENTS)} | Type: {kind} | {amount} | {_format(topic)}"
        services.append(text)
    yield from _rows("Service information", services)


def _requests(bag: Bag, events: set[str]) -> dict[str, str]:
    """Return how many requests and responses each service had, by the events of one side."""
    decoder, kinds = Decoder(), {name: Counter[int]() for name in events}
    for message in bag.messages(lambda name: name in events):
        kinds[message.topic.name][decoder.decode(message.topic, message.data).info.event_type] += 1
    return {
        name: f"Request Count: {max(each[0], each[1])} | Response Count: {max(each[2], each[3])}"
        for name, each in kinds.items()
    }


def missing(bag: Bag) -> Iterator[str]:
    """Yield what a recording lacks, a line each; call it once the bag has been read or counted."""
    for topic, count in sorted(bag.lost.items()):
        yield f"{topic}: {count} messages were published and never reached the recorder"
    yield from bag.problems


def _format(topic: TopicInfo) -> str:
    return f"Serialization Format: {topic.encoding}"


def _rows(name: str, texts: list[str]) -> Iterator[str]:
    yield _row(name, texts[0] if texts else "")
    yield from (" " * max(len(_INDENT), len(name) + 2) + text for text in texts[1:])


def _row(name: str, text: str) -> str:
    return f"{name + ': ':19}{text}".rstrip()


def _size(size: float) -> str:
    unit = min(int(math.log(max(size, 1.0), 1024.0)), len(_UNITS) - 1)
    return f"{size / 1024.0**unit:.1f} {_UNITS[unit]}"


def _time(stamp: int) -> str:
    seconds, nanoseconds = divmod(stamp, NANOSECONDS)
    local = datetime.fromtimestamp(seconds).astimezone()
    return f"{local:%b %e %Y %H:%M:%S}.{nanoseconds:09d} ({seconds}.{nanoseconds:09d})"
