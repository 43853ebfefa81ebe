"""When the messages of recordings are due; time is an argument."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.timing import NANOSECONDS


class Playback:
    """Recordings that run at some rate, can pause, and begin again where they shall loop.

    Args:
        bags: The recordings, whose messages are played in the order of their times.
        takes: Returns which topics are played.
        rate: Recorded seconds a second.
        offset: Where in the recording it begins [s].
        loop: Whether it begins again at its end.
        until: The last time that is played [ns]; the end if None.
        delay: How long to wait before each turn [s].
        settling: How long to wait before the first one besides [s].

    Attributes:
        paused: Whether it stands still.
        finished: Whether all messages have been given out.
        start: When it begins [ns].
    """

    def __init__(
        self,
        bags: Sequence[Bag],
        takes: Callable[[str], bool],
        rate: float = 1.0,
        offset: float = 0.0,
        loop: bool = False,
        until: int | None = None,
        delay: float = 0.0,
        settling: float = 0.0,
    ) -> None:
        self._bags = bags
        self._takes = takes
        self.rate = rate
        self.start = min(bag.start for bag in bags) + round(offset * NANOSECONDS)
        self._loop = loop
        self._until = until
        self._delay = delay
        self._time = float(self.start)
        self._wall: float | None = None
        self.paused = False
        self._messages: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self.finished = False
        self._rewind()
        self._waiting += settling
        self._began_again = False

    @property
    def time(self) -> int:
        """The present time within the recording [ns]."""
        return round(self._time)

    def _rewind(self) -> None:
        self._waiting = self._delay
        self.seek(self.start)

    def seek(self, time: int) -> None:
        """Continue at a time of the recording [ns], not before its start."""
        time = max(time, self.start)
        self._time = float(time)
        found = [bag.messages(self._takes, time) for bag in self._bags]
        self._messages = heapq.merge(*found, key=lambda message: message.time)
        self._advance()

    def _advance(self) -> None:
        self._next = next(self._messages, None)
        if self._next is not None and self._until is not None and self._next.time > self._until:
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
        if self._next is None and self._loop:
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
