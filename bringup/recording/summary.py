"""Summary of a recording and of its gaps: the lines of `ros2 bag info` and some of our own."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

from arjuna_core.bags.reader import Bag
from arjuna_core.timing import NANOSECONDS

_INDENT = " " * 19
_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")


def lines(bag: Bag) -> Iterator[str]:
    """Yield the lines that `ros2 bag info` prints of a recording."""
    counts = bag.counts
    names = [file.name for file in bag.files]
    yield _row("Files", names[0])
    yield from (f"{_INDENT}{name}" for name in names[1:])
    yield _row("Bag size", _size(bag.size))
    yield _row("Storage id", bag.storage)
    yield _row("Duration", f"{(bag.end - bag.start) / NANOSECONDS:.9f}s")
    yield _row("Start", _time(bag.start))
    yield _row("End", _time(bag.end))
    yield _row("Messages", str(counts.total()))
    for number, (name, topic) in enumerate(sorted(bag.topics.items())):
        text = (
            f"Topic: {name} | Type: {topic.type_name} | Count: {counts[name]} | "
            f"Serialization Format: {topic.encoding}"
        )
        yield _row("Topic information", text) if number == 0 else _INDENT + text


def missing(bag: Bag) -> Iterator[str]:
    """Yield what a recording lacks, a line each; call it once the bag has been read or counted."""
    for topic, count in sorted(bag.lost.items()):
        yield f"{topic}: {count} messages were published and never reached the recorder"
    yield from bag.problems


def _row(name: str, text: str) -> str:
    return f"{name + ':':19}{text}"


def _size(size: float) -> str:
    unit = 0
    while size >= 1024.0 and unit < len(_UNITS) - 1:
        size /= 1024.0
        unit += 1
    return f"{size:.1f} {_UNITS[unit]}"


def _time(stamp: int) -> str:
    seconds, nanoseconds = divmod(stamp, NANOSECONDS)
    local = datetime.fromtimestamp(seconds).astimezone()
    return f"{local:%b %e %Y %H:%M:%S}.{nanoseconds:09d} ({seconds}.{nanoseconds:09d})"
