"""The processes of ours on this machine, from /proc: group of nodes, domain, CPU time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_HOST = "bringup.host"
_DOMAIN = "ROS_DOMAIN_ID"
_TICK = os.sysconf("SC_CLK_TCK")  # [1/s]


@dataclass(frozen=True)
class HostProcess:
    """A process that runs a group of nodes.

    Attributes:
        cpu_time: Used so far [s].
    """

    pid: int
    group: str
    domain: int
    cpu_time: float


def host_processes(proc: Path = Path("/proc")) -> list[HostProcess]:
    """Return the processes of ours that this user may look at, by id."""
    found = [_host(folder) for folder in proc.glob("[0-9]*")]
    return sorted((host for host in found if host is not None), key=lambda host: host.pid)


def _host(folder: Path) -> HostProcess | None:
    try:
        words = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        if _HOST not in words[:4]:
            return None
        group = words[words.index(_HOST) + 1]
        domain = _domain((folder / "environ").read_bytes().decode(errors="replace"))
        times = (folder / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except (OSError, IndexError):
        return None  # it ended meanwhile, or is another user's
    return HostProcess(int(folder.name), group, domain, (int(times[11]) + int(times[12])) / _TICK)


def _domain(environment: str) -> int:
    for item in environment.split("\0"):
        name, _, value = item.partition("=")
        if name == _DOMAIN and value.isascii() and value.isdigit():
            return int(value)
    return 0
