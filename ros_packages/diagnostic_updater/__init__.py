"""Diagnostics of a node: tasks that fill a status each, on /diagnostics once a period."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.time import Time

OK, WARN, ERROR, STALE = (
    getattr(DiagnosticStatus, name) for name in ("OK", "WARN", "ERROR", "STALE")
)


class DiagnosticStatusWrapper(DiagnosticStatus):
    """A status with what fills it."""

    def summary(self, *args: Any) -> None:
        """Set level and message: of another status, or both."""
        self.level, self.message = _level_and_message(args)

    def clearSummary(self) -> None:
        """Set the level to OK and the message to nothing."""
        self.summary(OK, "")

    def mergeSummary(self, *args: Any) -> None:
        """Take the worse level in; messages of levels of one kind, OK or not, are joined."""
        level, message = _level_and_message(args)
        if (level > OK) == (self.level > OK):
            self.message = "; ".join(filter(None, (self.message, message)))
        elif level > self.level:
            self.message = message
        self.level = max(self.level, level)

    def add(self, key: str, val: Any) -> None:
        """Add a key and a value."""
        self.values.append(KeyValue(key=key, value=str(val)))


def _level_and_message(args: tuple[Any, ...]) -> tuple[bytes, str]:
    if len(args) == 1:
        return args[0].level, args[0].message
    level, message = args
    return (bytes((level,)) if isinstance(level, int) else level), str(message)


class DiagnosticTask:
    """Fills a status; a subclass has `run`."""

    def __init__(self, name: str) -> None:
        self.name = name

    def getName(self) -> str:
        """Return its name."""
        return self.name

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A function that fills a status."""

    def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
        super().__init__(name)
        self.fn = fn

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        filled: DiagnosticStatusWrapper = self.fn(stat)
        return filled


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill one status, which is as bad as the worst of them."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.tasks: list[DiagnosticTask] = []

    def addTask(self, t: DiagnosticTask) -> None:
        """Add a task."""
        self.tasks.append(t)

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        before, combined = DiagnosticStatusWrapper(), DiagnosticStatusWrapper()
        before.summary(stat)
        for task in self.tasks:
            stat.summary(before)
            stat = task.run(stat)
            combined.mergeSummary(stat)
        stat.summary(combined)
        return stat


class Updater:
    """Runs a node's tasks once a period [s] and publishes their statuses.

    The parameter `diagnostic_updater.period` changes it, `diagnostic_updater.use_fqn` puts the
    node's namespace into the names.
    """

    def __init__(self, node: Node, period: float = 1.0) -> None:
        self.node = node
        self.tasks: list[DiagnosticTask] = []
        self.lock = threading.Lock()
        self.publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 1)
        self.verbose, self.hwid = False, ""
        self.period = float(self._parameter("diagnostic_updater.period", period))
        self.use_fqn = bool(self._parameter("diagnostic_updater.use_fqn", False))
        self.timer = node.create_timer(self.period, self.update)

    def _parameter(self, name: str, default: Any) -> Any:
        if self.node.has_parameter(name):
            return self.node.get_parameter(name).value
        return self.node.declare_parameter(name, default).value

    def setHardwareID(self, hwid: str) -> None:
        """Set what statuses have as their hardware's name."""
        self.hwid = hwid

    def add(self, *args: Any) -> None:
        """Add a task, or a name and a function."""
        task = args[0] if len(args) == 1 else FunctionDiagnosticTask(*args)
        with self.lock:
            self.tasks.append(task)
        stat = DiagnosticStatusWrapper(name=task.getName())
        stat.summary(OK, "Node starting up")
        self.publish(stat)

    def removeByName(self, name: str) -> bool:
        """Remove the first task of a name; return whether there was one."""
        with self.lock:
            found = next((task for task in self.tasks if task.getName() == name), None)
            if found is not None:
                self.tasks.remove(found)
        return found is not None

    def update(self) -> None:
        """Run all tasks and publish their statuses."""
        self.force_update()

    def force_update(self) -> None:
        """Run all tasks and publish their statuses now."""
        statuses = []
        with self.lock:
            for task in self.tasks:
                stat = DiagnosticStatusWrapper(name=task.getName(), hardware_id=self.hwid)
                stat.summary(ERROR, "No message was set")
                stat = task.run(stat)
                statuses.append(stat)
                if self.verbose and stat.level != OK:
                    text = f"{stat.name}: level {stat.level[0]}: {stat.message}"
                    self.node.get_logger().warning(text)
        self.publish(statuses)

    def broadcast(self, lvl: Any, msg: str) -> None:
        """Publish one level and message as the status of every task."""
        statuses = []
        for task in self.tasks:
            stat = DiagnosticStatusWrapper(name=task.getName(), hardware_id=self.hwid)
            stat.summary(lvl, msg)
            statuses.append(stat)
        self.publish(statuses)

    def publish(self, msg: Any) -> None:
        """Publish a status or a list of them, the node's name before theirs."""
        statuses = msg if isinstance(msg, list) else [msg]
        own = self.node.get_fully_qualified_name() if self.use_fqn else self.node.get_name()
        found = DiagnosticArray()
        found.header.stamp = self.node.get_clock().now().to_msg()
        for stat in statuses:
            plain = DiagnosticStatus(level=stat.level, name=f"{own.lstrip('/')}: {stat.name}")
            plain.message, plain.hardware_id = stat.message, stat.hardware_id
            plain.values = stat.values
            found.status.append(plain)
        self.publisher.publish(found)


class FrequencyStatusParam:
    """The bounds of a frequency [Hz], with a tolerance, over a number of updates.

    Args:
        freq_bound: With the keys `min` and, if there is one, `max`.
    """

    def __init__(
        self, freq_bound: Mapping[str, float], tolerance: float = 0.1, window_size: int = 5
    ) -> None:
        self.freq_bound, self.tolerance, self.window_size = freq_bound, tolerance, window_size


class FrequencyStatus(DiagnosticTask):
    """Whether an event comes as often as it should."""

    def __init__(self, params: FrequencyStatusParam, name: str = "FrequencyStatus") -> None:
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.clear()

    def clear(self) -> None:
        """Forget the events."""
        with self.lock:
            self.count = 0
            self._past = [(self._clock.now(), 0)] * self.params.window_size

    def tick(self) -> None:
        """Count an event."""
        with self.lock:
            self.count += 1

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        params, bound = self.params, self.params.freq_bound
        with self.lock:
            now, (since, before) = self._clock.now(), self._past.pop(0)
            self._past.append((now, self.count))
            events, window = self.count - before, (now - since).nanoseconds / 1e9
        frequency = events / window if window > 0.0 else 0.0
        least, most = bound["min"] * (1.0 - params.tolerance), bound.get("max")
        most = None if most is None else most * (1.0 + params.tolerance)
        if events == 0:
            stat.summary(ERROR, "No events recorded.")
        elif frequency < least:
            stat.summary(WARN, "Frequency too low.")
        elif most is not None and frequency > most:
            stat.summary(WARN, "Frequency too high.")
        else:
            stat.summary(OK, "Desired frequency met")
        stat.add("Events in window", f"{events:d}")
        stat.add("Events since startup", f"{self.count:d}")
        stat.add("Duration of window (s)", f"{window:f}")
        stat.add("Actual frequency (Hz)", f"{frequency:f}")
        if bound["min"] == bound.get("max"):
            stat.add("Target frequency (Hz)", f"{bound['min']:f}")
        if bound["min"] > 0:
            stat.add("Minimum acceptable frequency (Hz)", f"{least:f}")
        if most is not None:
            stat.add("Maximum acceptable frequency (Hz)", f"{most:f}")
        return stat


class TimeStampStatusParam:
    """How far stamps may lie ahead (negative) and back [s]."""

    def __init__(self, min_acceptable: float = -1.0, max_acceptable: float = 5.0) -> None:
        self.min_acceptable, self.max_acceptable = min_acceptable, max_acceptable


class TimeStampStatus(DiagnosticTask):
    """Whether stamps are near the time at which they come."""

    def __init__(
        self,
        params: TimeStampStatusParam | None = None,
        name: str = "Timestamp Status",
        clock: Clock | None = None,
    ) -> None:
        super().__init__(name)
        self.params = params or TimeStampStatusParam()
        self.lock = threading.Lock()
        self._clock = clock or Clock()
        self._delays: list[float] = []
        self.zero_seen = False
        self.early_count = self.late_count = self.zero_count = 0

    def tick(self, stamp: Any) -> None:
        """Take a stamp, a Time or seconds."""
        since = stamp.nanoseconds / 1e9 if isinstance(stamp, Time) else float(stamp)
        with self.lock:
            if since == 0.0:
                self.zero_seen = True
            else:
                self._delays.append(self._clock.now().nanoseconds / 1e9 - since)

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        with self.lock:
            low, high = min(self._delays, default=0.0), max(self._delays, default=0.0)
            seen, zero = bool(self._delays), self.zero_seen
            self._delays, self.zero_seen = [], False
        stat.summary(OK, "Timestamps are reasonable.")
        if not seen and not zero:
            stat.summary(WARN, "No data since last update.")
        if seen and low < self.params.min_acceptable:
            stat.summary(ERROR, "Timestamps too far in future seen.")
            self.early_count += 1
        if seen and high > self.params.max_acceptable:
            stat.summary(ERROR, "Timestamps too far in past seen.")
            self.late_count += 1
        if zero:
            stat.summary(ERROR, "Zero timestamp seen.")
            self.zero_count += 1
        stat.add("Earliest timestamp delay", f"{low:f}")
        stat.add("Latest timestamp delay", f"{high:f}")
        stat.add("Earliest acceptable timestamp delay", f"{self.params.min_acceptable:f}")
        stat.add("Latest acceptable timestamp delay", f"{self.params.max_acceptable:f}")
        stat.add("Late diagnostic update count", self.late_count)
        stat.add("Early diagnostic update count", self.early_count)
        stat.add("Zero seen diagnostic update count", self.zero_count)
        return stat


class Heartbeat(DiagnosticTask):
    """A status that is OK whenever it comes."""

    def __init__(self) -> None:
        super().__init__("Heartbeat")

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fill a status and return it."""
        stat.summary(OK, "Alive")
        return stat


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """How often messages of a topic come; `tick` counts one."""

    def __init__(self, name: str, diag: Updater, freq: FrequencyStatusParam) -> None:
        super().__init__(f"{name} topic status")
        self.diag, self.freq = diag, FrequencyStatus(freq)
        self.addTask(self.freq)
        self.diag.add(self)

    def tick(self) -> None:
        """Count a message."""
        self.freq.tick()

    def clear_window(self) -> None:
        """Forget the messages."""
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """How often messages of a topic come, and with which stamps."""

    def __init__(
        self, name: str, diag: Updater, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(name, diag, freq)
        self.stamp = TimeStampStatus(stamp, clock=diag.node.get_clock())
        self.addTask(self.stamp)

    def tick(self, stamp: Any = None) -> None:
        """Count a message with a stamp."""
        self.stamp.tick(stamp)
        super().tick()


class DiagnosedPublisher(TopicDiagnostic):
    """A publisher whose messages are counted."""

    def __init__(
        self, pub: Any, diag: Updater, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(pub.topic_name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message: Any) -> None:
        """Count a message and publish it."""
        self.tick(Time.from_msg(message.header.stamp))
        self.publisher.publish(message)
