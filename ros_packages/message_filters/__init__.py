"""Messages of several topics that belong together, and the last ones of one."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.clock import ClockType, ROSClock
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time

__all__ = ["ApproximateTimeSynchronizer", "Cache", "SimpleFilter", "Subscriber", "TimeSynchronizer"]


class SimpleFilter:
    """Hands what it is given to its callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., Any], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., Any], *args: Any) -> int:
        """Call a function with each message, and with arguments of one's own behind it."""
        number = len(self.callbacks)
        self.callbacks[number] = cb, args
        return number

    def signalMessage(self, *msg: Any) -> None:
        for callback, args in list(self.callbacks.values()):
            callback(*msg, *args)


class Subscriber(SimpleFilter):
    """The messages of a topic; `qos_profile` as for `Node.create_subscription`."""

    def __init__(
        self, node: Node, msg_type: Any, topic: str, qos_profile: Any = 10, **kwargs: Any
    ) -> None:
        super().__init__()
        self.node, self.topic = node, topic
        self.sub = node.create_subscription(
            msg_type, topic, self.callback, qos_profile=qos_profile, **kwargs
        )

    def callback(self, msg: Any) -> None:
        self.signalMessage(msg)

    def getTopic(self) -> str:
        return self.topic

    def unregister(self) -> None:
        self.node.destroy_subscription(self.sub)


def _stamp(message: Any, headerless: bool, clock: Any) -> Time | None:
    """Return a message's time; that of its arrival where it has none and may lack it."""
    if hasattr(message, "header") and hasattr(message.header, "stamp"):
        return Time.from_msg(message.header.stamp, clock_type=ClockType.ROS_TIME)
    return clock.now() if headerless else None


class Cache(SimpleFilter):
    """The last messages of a filter, by their times; without a header by arrival, if allowed."""

    def __init__(self, f: Any = None, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size, self.allow_headerless = cache_size, allow_headerless
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Time] = []
        self._clock = ROSClock()
        if f is not None:
            self.connectInput(f)

    def connectInput(self, f: Any) -> None:
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Keep a message, and hand it on."""
        stamp = _stamp(msg, self.allow_headerless, self._clock)
        if stamp is None:
            return
        self.cache_msgs.append(msg)
        self.cache_times.append(stamp)
        while len(self.cache_msgs) > self.cache_size:
            self.cache_msgs.pop(0)
            self.cache_times.pop(0)
        self.signalMessage(msg)

    def _kept(self) -> list[tuple[Time, Any]]:
        pairs = zip(self.cache_times, self.cache_msgs, strict=True)
        return sorted(pairs, key=lambda pair: pair[0].nanoseconds)

    def getInterval(self, from_stamp: Time, to_stamp: Time) -> list[Any]:
        assert from_stamp <= to_stamp
        return [msg for stamp, msg in self._kept() if from_stamp <= stamp <= to_stamp]

    def getElemAfterTime(self, stamp: Time) -> Any:
        """Return the oldest message from a time on, or None."""
        return next((msg for time, msg in self._kept() if time >= stamp), None)

    def getElemBeforeTime(self, stamp: Time) -> Any:
        """Return the newest message up to a time, or None."""
        return next((msg for time, msg in reversed(self._kept()) if time <= stamp), None)

    def getLastestTime(self) -> Time | None:
        return self._kept()[-1][0] if self.cache_times else None

    getLatestTime = getLastestTime

    def getOldestTime(self) -> Time | None:
        return self._kept()[0][0] if self.cache_times else None

    def getLast(self) -> Any:
        return self._kept()[-1][1] if self.cache_times else None


class TimeSynchronizer(SimpleFilter):
    """Messages of filters with one time, handed on together; a number of each is kept."""

    allow_headerless = False

    def __init__(self, fs: Sequence[Any], queue_size: int) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.lock = threading.Lock()
        self._clock = ROSClock()
        self.connectInput(fs)

    def connectInput(self, fs: Sequence[Any]) -> None:
        self.queues: list[dict[int, Any]] = [{} for _ in fs]
        self.input_connections = [
            f.registerCallback(self.add, queue, number)
            for number, (f, queue) in enumerate(zip(fs, self.queues, strict=True))
        ]

    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Keep a message, and hand on the set that it completes."""
        stamp = self._time(msg)
        if stamp is None:
            return
        with self.lock:
            my_queue[stamp.nanoseconds] = msg
            while len(my_queue) > self.queue_size:
                del my_queue[min(my_queue)]
            found = self._complete(stamp.nanoseconds, my_queue)
        if found is not None:
            self.signalMessage(*found)

    def _time(self, msg: Any) -> Time | None:
        return _stamp(msg, self.allow_headerless, self._clock)

    def _complete(self, stamp: int, mine: dict[int, Any]) -> list[Any] | None:
        """Take out and return the messages that belong to that of a time [ns]."""
        if any(stamp not in queue for queue in self.queues):
            return None
        return [queue.pop(stamp) for queue in self.queues]


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Messages of several filters whose times differ by less than a slop [s].

    Args:
        allow_headerless: Whether messages without a header count at their arrival.
        sync_arrival_time: Whether all count at their arrival.
    """

    def __init__(
        self,
        fs: Sequence[Any],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
        sync_arrival_time: bool = False,
    ) -> None:
        super().__init__(fs, queue_size)
        self.slop = Duration(seconds=slop)
        self.allow_headerless = allow_headerless
        self.sync_arrival_time = sync_arrival_time

    def _time(self, msg: Any) -> Time | None:
        return self._clock.now() if self.sync_arrival_time else super()._time(msg)

    def _complete(self, stamp: int, mine: dict[int, Any]) -> list[Any] | None:
        """Return the set nearest to a time [ns] that is within the slop."""
        slop = self.slop.nanoseconds
        choices = [
            [stamp]
            if queue is mine
            else sorted((t for t in queue if abs(t - stamp) <= slop), key=lambda t: abs(t - stamp))
            for queue in self.queues
        ]
        for times in itertools.product(*choices):
            if max(times) - min(times) <= slop:
                return [queue.pop(t) for queue, t in zip(self.queues, times, strict=True)]
        return None
