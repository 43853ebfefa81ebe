"""Processes started, watched, restarted when they die, and all ended at the end."""

from __future__ import annotations

import math
import os
import selectors
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from bringup.interrupts import was_interrupted
from bringup.processes.child import Child, ChildSpec, describe_exit
from bringup.processes.health import Heartbeat, RestartLimits, RestartPolicy, starved
from bringup.processes.output import OWN, Output, read_event

USAGE_EXIT = 2
"""The exit code of a process that refuses its input: to start it again changes nothing."""
QUIT_EXIT = 3
"""The exit code of a process that a client asked to quit, and all the others with it."""
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@dataclass(frozen=True)
class StopTimes:
    """Time limits for ending processes [s].

    Attributes:
        interrupt: From SIGINT until SIGTERM follows.
        terminate: From SIGTERM until SIGKILL follows.
        last_words: For a process that is stuck to print its stack.
        absence: Between two looks, after which the supervisor itself was stopped, or slept.
        tick: From one look to the next.
        again: From one signal to another that skips ahead; `timeout` sends one twice.
    """

    interrupt: float = 5.0
    terminate: float = 3.0
    last_words: float = 1.0
    absence: float = 1.0
    tick: float = 0.2
    again: float = 0.3


LIMITS = RestartLimits()
STOP_TIMES = StopTimes()


class _Supervised:
    """One process while it runs, else when it starts again."""

    def __init__(self, spec: ChildSpec, limits: RestartLimits) -> None:
        self.spec = spec
        self.policy = RestartPolicy(limits)
        self.child: Child | None = None
        self.start_at: float | None = 0.0
        self.heartbeat = Heartbeat()
        self.kill_at: float | None = None


class Supervisor:
    """Keeps processes running until SIGINT or SIGTERM, until one quits or one cannot be kept."""

    def __init__(
        self,
        specs: Sequence[ChildSpec],
        output: Output,
        limits: RestartLimits = LIMITS,
        times: StopTimes = STOP_TIMES,
    ) -> None:
        self._all = [_Supervised(spec, limits) for spec in specs]
        self._output = output
        self._times = times
        self._selector = selectors.DefaultSelector()
        self._signals, self._signalled_at = 0, -math.inf
        self._failed = False
        self._looked = time.monotonic()

    def run(self) -> int:
        """Run until stopped; return 0 after a clean stop, 1 if a process could not be kept."""
        with self._signals_caught():
            try:
                while not self._signals and not self._failed:
                    self._start_due()
                    self._wait(self._times.tick)
                    self._reap()
                    self._end_silent(time.monotonic())
            finally:
                self._stop_all()
        return 1 if self._failed else 0

    @contextmanager
    def _signals_caught(self) -> Iterator[None]:
        """Turn SIGINT and SIGTERM into a count, and wake the selector."""
        reader, writer = os.pipe()
        for end in (reader, writer):
            os.set_blocking(end, False)
        self._selector.register(reader, selectors.EVENT_READ, lambda: bool(os.read(reader, 64)))
        previous = {each: signal.signal(each, self._on_signal) for each in _STOP_SIGNALS}
        wakeup = signal.set_wakeup_fd(writer)
        try:
            self._signals += was_interrupted()
            yield
        finally:
            signal.set_wakeup_fd(wakeup)
            for each, handler in previous.items():
                signal.signal(each, handler)
            self._selector.close()
            os.close(reader)
            os.close(writer)

    def _on_signal(self, number: int, frame: object) -> None:
        now = time.monotonic()
        if now - self._signalled_at > self._times.again:
            self._signals += 1
        self._signalled_at = now

    def _start_due(self) -> None:
        now = time.monotonic()
        for one in self._all:
            if one.start_at is not None and now >= one.start_at:
                self._start(one)

    def _start(self, one: _Supervised) -> None:
        name = one.spec.name
        one.start_at = one.kill_at = None
        one.heartbeat = Heartbeat()
        one.child = Child(one.spec, lambda line: self._take(one, line))
        self._selector.register(one.child.output, selectors.EVENT_READ, one.child.read)
        self._output.state(name, "started")

    def _wait(self, timeout: float) -> None:
        """Hand on output until a timeout [s], a signal, or the first quiet moment."""
        for key, _ in self._selector.select(timeout):
            if not key.data():
                self._selector.unregister(key.fd)
        self._output.tick()

    def _take(self, one: _Supervised, line: str) -> None:
        """Take a line of a process: a sign of life, an event, or a line of its log."""
        event = read_event(line)
        if event is None:
            self._output.line(one.spec.name, line)
        elif "alive" not in event:
            self._output.event(one.spec.name, event)
        elif one.child is not None:
            patience = float(event["alive"])
            one.heartbeat.hear(time.monotonic(), patience, starved(one.child.pid))

    def _end_silent(self, now: float) -> None:
        """End processes that are silent for too long; each prints its stack, and starts again."""
        absent, self._looked = now - self._looked, now
        for one in self._all:
            if one.child is None:
                continue
            if absent > self._times.absence:
                one.heartbeat.excuse(absent)
            silent = one.heartbeat.silence(now, starved(one.child.pid))
            if one.kill_at is not None and now >= one.kill_at:
                one.child.send(signal.SIGKILL)
            elif one.kill_at is None and silent is not None:
                one.kill_at = now + self._times.last_words
                name = one.spec.name
                text = f"{name} has not answered for {silent:.1f} s: ended"
                self._output.state(name, "hung", text)
                one.child.send(signal.SIGABRT)  # Python then says where it is
                one.child.send(signal.SIGCONT)

    def _reap(self, restart: bool = True) -> None:
        for one in self._all:
            code = one.child.poll() if one.child else None
            if one.child is not None and code is not None:
                if one.child.output in self._selector.get_map():
                    self._selector.unregister(one.child.output)
                one.child.close()
                one.child = None
                if restart:
                    self._plan_restart(one, code)
                else:
                    self._output.state(one.spec.name, "ended")

    def _plan_restart(self, one: _Supervised, code: int) -> None:
        name, how, now = one.spec.name, describe_exit(code), time.monotonic()
        if code == QUIT_EXIT:
            self._signals += 1
            self._output.state(name, "quit", f"{name} quit, and so do all")
            return
        was_up = self._output.start_up.was_up(name)
        delay = None if code == USAGE_EXIT else one.policy.on_death(now, was_up)
        if delay is not None:
            one.start_at = now + delay
            text = f"{name} died ({how}); it starts again in {delay:g} s"
            self._output.state(name, "died", text)
            return
        self._failed = self._failed or one.spec.needed
        why = "it refused its input" if code == USAGE_EXIT else "it dies again and again"
        text = f"{name} died ({how}) and {why}: giving up; see its lines above"
        self._output.state(name, "failed", text)

    def _stop_all(self) -> None:
        """Ask the processes to end by ever firmer signals; a further Ctrl-C skips ahead."""
        for number, patience in (
            (signal.SIGINT, self._times.interrupt),
            (signal.SIGTERM, self._times.terminate),
            (signal.SIGKILL, self._times.terminate),
        ):
            for one in self._all:
                if one.child is not None:
                    one.child.send(number)
            self._wait_for_end(patience)
            late = [one.spec.name for one in self._all if one.child is not None]
            if not late:
                return
            self._output.line(OWN, f"{', '.join(late)} did not end on {number.name}")

    def _wait_for_end(self, patience: float) -> None:
        signals, deadline = self._signals, time.monotonic() + patience
        while any(one.child for one in self._all):
            if time.monotonic() >= deadline or self._signals != signals:
                return
            self._wait(self._times.tick / 4)
            self._reap(restart=False)
