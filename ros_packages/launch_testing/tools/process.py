"""Processes that a test starts by itself, while what it described runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from launch import LaunchDescription
from launch.events.process import ProcessExited, ShutdownProcess

from launch_testing.records import (
    IoHandler,
    NoMatchingProcessException,
    ProcInfoHandler,
    text_matcher,
)


class ProcessProxy:
    """A process that a test has started, with what it wrote and how it ended."""

    def __init__(
        self,
        process_action: Any,
        proc_info: ProcInfoHandler,
        proc_output: IoHandler,
        *,
        output_filter: Callable[[str], str] | None = None,
    ) -> None:
        self._action, self._info, self._output = process_action, proc_info, proc_output
        self._filter = output_filter or (lambda text: text)

    def wait_for_shutdown(self, timeout: float = 10.0) -> bool:
        """Return whether it ends within a time [s]."""
        return self._info.wait(lambda: self.terminated, timeout)

    def wait_for_output(self, condition: Any = None, timeout: float = 10.0) -> bool:
        """Return whether its output fulfils a condition within a time [s]."""
        fulfils = text_matcher(condition) if condition is not None else bool
        return self._output.wait(lambda: fulfils(self.output), timeout)

    @property
    def running(self) -> bool:
        return self._action in self._info.processes() and not self.terminated

    @property
    def terminated(self) -> bool:
        known = self._action in self._info.processes()
        return known and isinstance(self._info[self._action], ProcessExited)

    @property
    def output(self) -> str:
        return self._filter(self._output.text([self._action]))

    @property
    def stdout(self) -> str:
        return self._filter(self._output.text([self._action], "stdout"))

    @property
    def stderr(self) -> str:
        return self._filter(self._output.text([self._action], "stderr"))

    @property
    def exit_code(self) -> int:
        """Its exit code.

        Raises:
            NoMatchingProcessException: It has not.
        """
        if not self.terminated:
            raise NoMatchingProcessException("the process has not ended")
        return int(self._info[self._action].returncode)


@contextmanager
def launch_process(
    launch_service: Any,
    process_action: Any,
    proc_info: ProcInfoHandler,
    proc_output: IoHandler,
    *,
    output_filter: Callable[[str], str] | None = None,
) -> Iterator[ProcessProxy]:
    """Run a process beside those of the launch; it is ended behind the block."""
    launch_service.include_launch_description(LaunchDescription([process_action]))
    proc_info.assertWaitForStartup(process=process_action, timeout=10.0)
    proxy = ProcessProxy(process_action, proc_info, proc_output, output_filter=output_filter)
    try:
        yield proxy
    finally:
        if not proxy.terminated:
            end = ShutdownProcess(process_matcher=lambda one: one is process_action)
            launch_service.emit_event(end)
            proxy.wait_for_shutdown(timeout=15.0)
