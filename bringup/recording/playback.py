"""When the messages of recordings are due; time is an argument."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.timing import NANOSECONDS


@dataclass(frozen=True)
class PlayOptions:
    """Options of playing.

    Attributes:
        rate: Recorded seconds a second.
        offset: Where in the recording to begin [s].
        until: The last time that is played [ns]; the end if None.
        clock_hz: How often to publish the recorded time on /clock [Hz]; 0 for not.
        clock_topics: Topics before whose messages it is published, too; None for all.
        recorded_clock: Whether a recorded /clock is played instead of one that is made.
        delay: How long to wait before each turn [s].
        settling: How long to wait at first until those who listen have found the player [s].
        overrides: Profiles (QoSProfile) of topics whatever the recording says.
        acked_timeout: How long to wait at the end for those who listen [s], 0 for ever; None not.
        requests: The event whose request is sent to its service in place of the events; see
            `REQUESTS`; None to publish the events.
        controlled: Whether it is rosbag2's: offers its services, announces new files and logs
            its sentences.
        burst: How many messages are published at once at the beginning, 0 for all; None for not.
    """

    takes: Callable[[str], bool] = lambda topic: True
    rate: float = 1.0
    offset: float = 0.0
    loop: bool = False
    until: int | None = None
    paused: bool = False
    clock_hz: float = 0.0
    clock_topics: Collection[str] | None = ()
    recorded_clock: bool = True
    delay: float = 0.0
    settling: float = 0.0
    remap: Mapping[str, str] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    acked_timeout: float | None = None
    requests: int | None = None
    keys: bool = True
    node_name: str = "player"
    controlled: bool = False
    burst: int | None = None

    @property
    def makes_clock(self) -> bool:
        """Return whether /clock is published."""
        return self.clock_hz > 0.0 or self.clock_topics is None or bool(self.clock_topics)


class Playback:
    """Recordings that run at some rate, can pause, and begin again where they shall loop.

    Attributes:
        start: When it begins [ns].
    """

    def __init__(self, bags: Sequence[Bag], options: PlayOptions) -> None:
        self._bags, self._options = bags, options
        self.rate, self.paused = options.rate, options.paused
        self.start = min(bag.start for bag in bags) + round(options.offset * NANOSECONDS)
        self._time = float(self.start)
        self._wall: float | None = None
        self._messages: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self.finished = False
        self._rewind()
        self._waiting += options.settling
        self._began_again = False

    @property
    def time(self) -> int:
        """The present time within the recording [ns]."""
        return round(self._time)

    def _rewind(self) -> None:
        self._waiting = self._options.delay
        self.seek(self.start)

    def seek(self, time: int) -> None:
        """Continue at a time of the recording [ns], not before its start."""
        time = max(time, self.start)
        self._time = float(time)
        found = [bag.messages(self._options.takes, time) for bag in self._bags]
        self._messages = heapq.merge(*found, key=lambda message: message.time)
        self._advance()

    def _advance(self) -> None:
        self._next = next(self._messages, None)
        until = self._options.until
        if self._next is not None and until is not None and self._next.time > until:
            self._next = None
        self.finished = self._next is None

    def advance(self, wall: float) -> None:
        """Move on to a wall time [s]."""
        if self._wall is not None:
            passed = wall - self._wall
            waited = min(self._waiting, passed)
            self._waiting -= waited
            if not self.paused:
                self._time += (passed - waited) * self.rate * NANOSECONDS
        self._wall = wall
        self._began_again = False

    def due(self) -> BagMessage | None:
        """Return the next message if its time has come."""
        if self._next is None or self.paused or self._waiting > 0.0:
            return None
        if self._began_again or self._next.time > self._time:
            return None
        message = self._next
        self._advance()
        if self._next is None and self._options.loop:
            self._rewind()
            self._began_again = True  # a recording of one moment would be due without end
        return message

    def play_next(self) -> BagMessage | None:
        """Return the next message of a paused playback, at whose time it then is."""
        if not self.paused or self._next is None:
            return None
        message = self._next
        self._time = float(message.time)
        self._advance()
        return message

    def wait(self) -> float:
        """Return how long to wait for the next message [s, wall]; infinite while it is paused."""
        if self._waiting > 0.0:
            return self._waiting
        if self._next is None or self.paused:
            return float("inf")
        return max(self._next.time - self._time, 0.0) / NANOSECONDS / self.rate
