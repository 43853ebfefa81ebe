"""Processes: those that are meant, and one that keeps a launch alive."""

from __future__ import annotations

import sys
from typing import Any

from launch.actions import ExecuteProcess

from launch_testing.records import NO_CMD_ARGS, NoMatchingProcessException, resolve

__all__ = ["NO_CMD_ARGS", "KeepAliveProc", "NoMatchingProcessException", "resolveProcesses"]


class KeepAliveProc(ExecuteProcess):
    """A process that does nothing until the launch ends."""

    def __init__(self) -> None:
        wait = "import signal; signal.signal(signal.SIGINT, lambda *_: exit(0)); signal.pause()"
        super().__init__(cmd=[sys.executable, "-c", wait], name="keep_alive")


def resolveProcesses(
    info_obj: Any, *, process: Any = None, cmd_args: Any = None, strict_proc_matching: bool = True
) -> list[Any]:
    """Return the actions that are meant; see `records.resolve`."""
    return resolve(info_obj, process, cmd_args, strict_proc_matching)
