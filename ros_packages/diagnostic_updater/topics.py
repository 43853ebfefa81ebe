"""Tasks for events and topics: their frequencies and stamps."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.time import Time

from diagnostic_updater.updater import (
    ERROR,
    OK,
    WARN,
    CompositeDiagnosticTask,
    DiagnosticStatusWrapper,
    DiagnosticTask,
    Updater,
)


@dataclass
class FrequencyStatusParam:
    """Bounds of a frequency [Hz], `min` and perhaps `max`, its tolerance and count of updates."""

    freq_bound: Mapping[str, float]
    tolerance: float = 0.1
    window_size: int = 5


class FrequencyStatus(DiagnosticTask):
    """The frequency of an event, held to its bounds."""

    def __init__(self, params: FrequencyStatusParam, name: str = "FrequencyStatus") -> None:
        super().__init__(name)
        self.params = params
        self.lock = threading.Lock()
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.clear()

    def clear(self) -> None:
        with self.lock:
            self.count = 0
            self._past = [(self._clock.now(), 0)] * self.params.window_size

    def tick(self) -> None:
        with self.lock:
            self.count += 1

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
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


@dataclass
class TimeStampStatusParam:
    """The greatest lead (negative) and age of stamps [s]."""

    min_acceptable: float = -1.0
    max_acceptable: float = 5.0


class TimeStampStatus(DiagnosticTask):
    """The ages of stamps when they come, held to their bounds."""

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
        stat.summary(OK, "Alive")
        return stat


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """The frequency of a topic's messages; `tick` counts one."""

    def __init__(self, name: str, diag: Updater, freq: FrequencyStatusParam) -> None:
        super().__init__(f"{name} topic status")
        self.diag, self.freq = diag, FrequencyStatus(freq)
        self.addTask(self.freq)
        self.diag.add(self)

    def tick(self) -> None:
        self.freq.tick()

    def clear_window(self) -> None:
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """The frequency and the stamps of a topic's messages."""

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
        self.tick(Time.from_msg(message.header.stamp))
        self.publisher.publish(message)
