"""Processes found and ended by the beginning of their commands."""

# ruff: noqa: T201 - the original's words
from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

__all__ = ["find_os_processes", "kill_os_processes", "kill_process"]


def find_os_processes(name: str) -> list[tuple[str, str]]:
    """Return id and command of each process whose command begins with a text."""
    found = []
    for folder in Path("/proc").glob("[0-9]*") if name else ():
        with contextlib.suppress(OSError):  # it may end meanwhile
            words = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
            command = " ".join(words).strip()
            if command.startswith(name):
                found.append((folder.name, command))
    return found


def kill_process(pid: str) -> None:
    """End a process by force, and print whether that was possible."""
    try:
        os.kill(int(pid), signal.SIGKILL)
        print(f"Successfully killed process with PID: {pid}")
    except OSError as error:
        print(f"Failed to kill process with PID: {pid}. Error: {error}")


def kill_os_processes(name: str) -> None:
    """End by force each process whose command begins with a text."""
    found = find_os_processes(name)
    for pid, _ in found:
        kill_process(pid)
    if not found:
        print(f"No processes found starting with {name}")
