"""The machine, this terminal's environment and the processes of ours, as /proc shows them."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from bringup.doctor.snapshot import Machine

_VARIABLES = (
    *("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "ROS_DISTRO"),
    *("ROS_STATIC_PEERS", "RMW_IMPLEMENTATION", "MUJOCO_GL", "PYTHONPATH"),
)
_LIBRARIES = ("mujoco", "numba", "rclpy")
_MESSAGES = ("nav2_msgs", "slam_toolbox", "simulation_interfaces", "arjuna_interfaces", "tf2_msgs")
_SHADOWED = ("rclpy", "tf2_ros", "nav2_msgs", "nav2_simple_commander")
_CHECKOUT = Path(__file__).resolve().parents[2]


def read_machine() -> Machine:
    """Return the facts of the machine."""
    return Machine(
        python=(sys.version_info.major, sys.version_info.minor),
        missing=tuple(name for name in (*_LIBRARIES, *_MESSAGES) if _origin(name) is None),
        foreign=_foreign(),
        environment={name: os.environ[name] for name in _VARIABLES if name in os.environ},
        gl_error=_gl_error(),
        disk_free=shutil.disk_usage(Path.home()).free / 2**30,
        memory_free=_memory_free(),
        load=os.getloadavg()[0] / (os.cpu_count() or 1),
        domains=tuple(sorted({host.domain for host in host_processes()})),
    )


def _origin(module: str) -> str | None:
    spec = importlib.util.find_spec(module)
    if spec is None:
        return None
    return spec.origin or next(iter(spec.submodule_search_locations or ()), None)


def _foreign() -> dict[str, str]:
    """Return the modules that come from PYTHONPATH, where a sourced ROS puts its own."""
    folders = [entry for entry in os.environ.get("PYTHONPATH", "").split(os.pathsep) if entry]
    outside = tuple(entry for entry in folders if not _CHECKOUT.is_relative_to(entry))
    origins = {name: _origin(name) for name in _SHADOWED}
    return {
        name: origin
        for name, origin in origins.items()
        if origin is not None and outside and origin.startswith(outside)
    }


def _memory_free() -> float:
    for line in Path("/proc/meminfo").read_text(encoding="utf-8").splitlines():
        name, _, rest = line.partition(":")
        if name == "MemAvailable":
            return int(rest.split()[0]) / 2**20
    return 0.0


def _gl_error() -> str:
    try:
        from arjuna_sim.devices.camera import gl_error
    except (ImportError, RuntimeError, OSError) as error:
        return str(error)
    return gl_error()


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
