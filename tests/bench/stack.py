"""The stack in processes and real time: until active, then CPU and memory idle and driving."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.client.session import Connection
from bringup.doctor.machine import host_processes
from bringup.parameters import options
from tests.helpers.processes import Lines

_GOALS = (SE2(1.5, 1.0, 0.5), SE2(3.0, 1.2, 0.0), SE2(1.0, -1.0, 1.5), SE2(0.0, 0.0, 0.0))
_PERIOD = 0.05  # of the controller [s]
ACTIVE = "Managed nodes are active"
_START, _GOAL = 60.0, 90.0  # [s] at most
_SETTLE = 5.0  # after the start [s]
_MEGA = 1e6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--seconds", type=float, default=20.0, help="idle, before it drives (%(default)s) [s]"
    )
    parser.add_argument(
        "--domain-id", type=options.domain_id, default=97, help="of ROS, its own (%(default)s)"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Start sim and nav as a user does, wait, then drive to four goals in the room.

    Returns:
        `active_s` from nav's start until its nodes are active; `idle` and `driving` with the CPU
        of each process [of a core]; `memory_mb` of each; of the commands while it drives
        `jitter_p95_s` from their period, and `latency_p95_s` since the last scan; `succeeded`.
    """
    os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    with started("sim"):
        start_time = time.monotonic()
        with (
            started("nav", "--map", str(shipped_file("maps/arjuna_room.yaml"))),
            closing(Connection("bench_stack")) as session,
        ):
            result: dict[str, Any] = {"active_s": time.monotonic() - start_time}
            session.pause(_SETTLE)
            with _usage(result, "idle"):
                session.pause(arguments.seconds)
            scans, commands = _watched(session)
            with _usage(result, "driving"):
                ends = [Goals(session).navigate(goal, _GOAL) for goal in _GOALS]
            result["succeeded"] = sum(end.succeeded for end in ends)
            result |= _command_times(np.array(scans), np.array(commands))
            result["memory_mb"] = {h.group: _memory(h.pid) for h in _hosts()}
    for name, value in result.items():
        print(f"{name:16}{value}")
    return result


@contextmanager
def started(*words: str) -> Iterator[None]:
    """Run a command of ours until its nodes are active, and beyond."""
    with Lines("-m", "bringup", *words) as lines:
        lines.wait_for(ACTIVE, within=_START)
        yield


@contextmanager
def _usage(result: dict[str, Any], name: str) -> Iterator[None]:
    """Note what each process takes of a core meanwhile."""
    before, start_time = {h.group: h.cpu_time for h in _hosts()}, time.monotonic()
    yield
    passed = time.monotonic() - start_time
    result[name] = {h.group: round((h.cpu_time - before[h.group]) / passed, 3) for h in _hosts()}


def _hosts() -> list[Any]:
    domain = int(os.environ["ROS_DOMAIN_ID"])
    return [host for host in host_processes() if host.domain == domain]


def _watched(session: Connection) -> tuple[list[float], list[float]]:
    """Return when scans and commands come from now on, both filled while the session runs."""
    times: tuple[list[float], list[float]] = ([], [])

    def noted(into: list[float]) -> Callable[[Any], None]:
        return lambda message: into.append(time.monotonic())

    node = session.client
    node.create_subscription(LaserScan, "/scan", noted(times[0]), qos.SENSOR_SUBSCRIPTION)
    node.create_subscription(Twist, "/cmd_vel", noted(times[1]), qos.DEFAULT)
    return times


def _command_times(scans: Any, commands: Any) -> dict[str, float]:
    """Return how even commands come, and how old the newest scan is then."""
    gaps = np.diff(commands)
    gaps = gaps[gaps < 10.0 * _PERIOD]  # between goals there are none
    last = scans[np.maximum(np.searchsorted(scans, commands) - 1, 0)]
    return {
        "jitter_p95_s": float(np.percentile(np.abs(gaps - _PERIOD), 95)),
        "latency_p95_s": float(np.percentile(commands - last, 95)),
    }


def _memory(pid: int) -> float:
    """Return a process's memory in use [MB]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1])
    return round(pages * os.sysconf("SC_PAGE_SIZE") / _MEGA, 1)
