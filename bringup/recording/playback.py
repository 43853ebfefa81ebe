"""When the messages of a recording are due; time is an argument."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.timing import NANOSECONDS


class Playback:
    """A recording that runs at some rate, can pause, and begins again where it shall loop.

    Args:
        takes: Returns which topics are played.
        rate: Recorded seconds a second.
        offset: Where in the recording it begins [s].
        loop: Whether it begins again at its end.

    Attributes:
        paused: Whether it stands still.
        finished: Whether all messages have been given out.
    """

    def __init__(
        self,
        bag: Bag,
        takes: Callable[[str], bool],
        rate: float = 1.0,
        offset: float = 0.0,
        loop: bool = False,
    ) -> None:
        self._bag = bag
        self._takes = takes
        self._rate = rate
        self._start = bag.start + round(offset * NANOSECONDS)
        self._loop = loop
        self._time = float(self._start)
        self._wall: float | None = None
        self.paused = False
        self._messages: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self._rewind()
        self._began_again = False
        self.finished = self._next is None

    @property
    def time(self) -> int:
        """The present time within the recording [ns]."""
        return round(self._time)

    def _rewind(self) -> None:
        self._time = float(self._start)
        self._messages = self._bag.messages(self._takes, self._start)
        self._next = next(self._messages, None)

    def advance(self, wall: float) -> None:
        """Move on to a wall time [s]."""
        if self._wall is not None and not self.paused:
            self._time += (wall - self._wall) * self._rate * NANOSECONDS
        self._wall = wall
        self._began_again = False

    def due(self) -> BagMessage | None:
        """Return the next message if its time has come."""
        if self._next is None or self.paused or self._began_again or self._next.time > self._time:
            return None
        message, self._next = self._next, next(self._messages, None)
        if self._next is None and self._loop:
            self._rewind()
            self._began_again = True  # a recording of one moment would be due without end
        self.finished = self._next is None
        return message

    def wait(self) -> float:
        """Return how long to wait for the next message [s, wall]; infinite while it is paused."""
        if self._next is None or self.paused:
            return float("inf")
        return max(self._next.time - self._time, 0.0) / NANOSECONDS / self._rate
