"""Records of the processes of a launch, by process; and waiting for them."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Generic, TypeVar

from launch.events.process import ProcessEvent, ProcessExited, ProcessIO

Record = TypeVar("Record", bound=ProcessEvent)
NO_CMD_ARGS = object()
"""The `cmd_args` of a process that has none."""


class NoMatchingProcessException(Exception):
    """Nothing is known of such a process."""


class Records(Generic[Record]):
    """Events of processes, in the order in which they came, by the action that runs each."""

    def __init__(self) -> None:
        self._all: list[Record] = []
        self._changed = threading.Condition()

    def append(self, event: Record) -> None:
        """Take an event, and wake who waits for it."""
        with self._changed:
            self._all.append(event)
            self._changed.notify_all()

    track = append

    def processes(self) -> list[Any]:
        """Return the actions whose processes have done something, each once."""
        return list(dict.fromkeys(event.action for event in self._all))

    def process_names(self) -> list[str]:
        return list(dict.fromkeys(event.process_name for event in self._all))

    def of(self, process: Any) -> list[Record]:
        """Return the events of an action, or of a process by its name.

        Raises:
            KeyError: There are none.
        """
        key = process if isinstance(process, str) else None
        found = [e for e in self._all if (e.process_name == key if key else e.action is process)]
        if not found:
            raise KeyError(f"no process '{key or name_of(process)}'; valid: {self.process_names()}")
        return found

    def wait(self, is_there: Callable[[], bool], timeout: float) -> bool:
        """Return whether something is there within a time [s, wall]."""
        with self._changed:
            return self._changed.wait_for(is_there, timeout)


class IoHandler(Records[ProcessIO]):
    """Output of processes: `proc_output[action]` is a list of events with `text`."""

    def __getitem__(self, process: Any) -> list[ProcessIO]:
        return self.of(process)

    def __iter__(self) -> Iterator[ProcessIO]:
        return iter(list(self._all))

    def text(self, processes: Iterable[Any], stream: str = "both") -> str:
        """Return what processes have written to `stdout`, `stderr` or both."""
        chosen, number = set(processes), {"stdout": 1, "stderr": 2}.get(stream)
        events = [e for e in self if e.action in chosen and number in (None, e.fd)]
        return b"".join(event.text for event in events).decode("utf-8", "replace")

    def waitFor(
        self,
        expected_output: Any,
        process: Any = None,
        cmd_args: Any = None,
        *,
        output_filter: Callable[[str], str] | None = None,
        timeout: float = 10.0,
        strict_proc_matching: bool = True,
        stream: str = "stderr",
    ) -> bool:
        """Return whether processes write what is expected within a time [s]."""
        matches = text_matcher(expected_output)

        def came() -> bool:
            try:
                found = resolve(self, process, cmd_args, strict_proc_matching)
            except NoMatchingProcessException:
                return False
            text = self.text(found, stream)
            return matches(output_filter(text) if output_filter else text)

        return self.wait(came, timeout)

    def assertWaitFor(
        self, expected_output: Any, process: Any = None, cmd_args: Any = None, **how: Any
    ) -> None:
        """Wait until processes write what is expected; see `waitFor`.

        Raises:
            AssertionError: It did not come in time.
        """
        if not self.waitFor(expected_output, process, cmd_args, **how):
            chosen = "any process" if process is None else f"'{name_of(process)}'"
            stream = how.get("stream", "stderr")
            last = self.text(self.processes(), stream).splitlines()[-5:]
            raise AssertionError(
                f"{expected_output!r} did not come from {chosen} on {stream} within"
                f" {how.get('timeout', 10.0):g} s; the last lines there: {last}"
            )


class ProcInfoHandler(Records[ProcessEvent]):
    """Starts and ends of processes: `proc_info[action]` is the last of one."""

    def __getitem__(self, process: Any) -> Any:
        return self.of(process)[-1]

    def __iter__(self) -> Iterator[Any]:
        return iter([self[process] for process in self.processes()])

    def _has(self, process: Any, cmd_args: Any, ended: bool) -> bool:
        try:
            found = resolve(self, process, cmd_args, False)
        except NoMatchingProcessException:
            return False
        return not ended or all(isinstance(self[one], ProcessExited) for one in found)

    def _await(self, process: Any, cmd_args: Any, ended: bool, timeout: float) -> None:
        if not self.wait(lambda: self._has(process, cmd_args, ended), timeout):
            did = "end" if ended else "start"
            raise AssertionError(
                f"'{name_of(process)}' did not {did} within {timeout:g} s;"
                f" there are: {self.process_names()}"
            )

    def assertWaitForShutdown(
        self, process: Any, cmd_args: Any = None, *, timeout: float = 10.0
    ) -> None:
        """Wait until a process has ended.

        Raises:
            AssertionError: It did not within the time [s].
        """
        self._await(process, cmd_args, True, timeout)

    def assertWaitForStartup(
        self, process: Any, cmd_args: Any = None, *, timeout: float = 10.0
    ) -> None:
        """Wait until a process has started.

        Raises:
            AssertionError: It did not within the time [s].
        """
        self._await(process, cmd_args, False, timeout)


ActiveIoHandler, ActiveProcInfoHandler = IoHandler, ProcInfoHandler


def name_of(process: Any) -> str:
    """Return the name of a process, which an action has when it has started."""
    if isinstance(process, str):
        return process
    return str(process.process_details.get("name") or process.describe())


def resolve(
    records: Records[Any], process: Any = None, cmd_args: Any = None, strict: bool = True
) -> list[Any]:
    """Return the actions that are meant: all, one, or those whose process' name holds a text.

    Args:
        cmd_args: An argument that its command has, or `NO_CMD_ARGS`.
        strict: Whether a text must mean one process.

    Raises:
        NoMatchingProcessException: There is none.
    """
    known = records.processes()
    if isinstance(process, str):
        found = [one for one in known if process in name_of(one)]
        words = {one: one.process_details["cmd"][1:] for one in found}
        if cmd_args is NO_CMD_ARGS:
            found = [one for one in found if not words[one]]
        elif cmd_args is not None:
            found = [one for one in found if cmd_args in words[one]]
        if strict and len(found) > 1:
            names = [name_of(one) for one in found]
            raise AssertionError(f"'{process}' is {names}; valid: one, or strict_proc_matching")
    else:
        found = [one for one in known if process is None or one is process]
    if not found:
        name = "any process" if process is None else f"'{name_of(process)}'"
        raise NoMatchingProcessException(
            f"nothing is known of {name}; there are: {records.process_names()}"
        )
    return found


def text_matcher(expected: Any) -> Callable[[str], bool]:
    """Return what matches a text: a part of it, a pattern, or several one after another."""
    if isinstance(expected, str):
        return lambda text: expected in text
    if isinstance(expected, re.Pattern):
        return lambda text: expected.search(text) is not None
    if isinstance(expected, Iterable):
        parts = list(expected)

        def in_order(text: str) -> bool:
            at = 0
            for part in parts:
                pattern = part if isinstance(part, re.Pattern) else re.compile(re.escape(part))
                found = pattern.search(text, at)
                if found is None:
                    return False
                at = found.end()
            return True

        return in_order
    if callable(expected):
        return lambda text: bool(expected(text))
    raise TypeError(f"{expected!r} is no output; valid: a text, a pattern, or a list of them")
