"""The machine and this terminal's environment, read."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from pathlib import Path

from bringup.doctor.processes import host_processes
from bringup.doctor.snapshot import Machine

_VARIABLES = (
    *("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "ROS_DISTRO"),
    *("RMW_IMPLEMENTATION", "MUJOCO_GL", "PYTHONPATH"),
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
    """Return the file or folder that a module would be imported from; None for none."""
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
