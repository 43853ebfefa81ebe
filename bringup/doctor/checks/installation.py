"""Python, its environment, the compiled messages, and a sourced ROS that comes first."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_OLDEST, _NEWEST = (3, 10), (3, 13)
_DISTRO = "jazzy"


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what is wrong with the installation."""
    machine = snapshot.machine
    found = []
    if not _OLDEST <= machine.python <= _NEWEST:
        version = ".".join(map(str, machine.python))
        found.append(
            Finding(f"Python {version} is none of 3.10 to 3.13", "make setup PYTHON=python3.12")
        )
    if machine.missing:
        what = f"not installed in this Python: {', '.join(machine.missing)}"
        found.append(Finding(what, "make setup, then .venv/bin/python -m bringup"))
    found += _shadows(machine.foreign, machine.environment)
    return found


def _shadows(foreign: dict[str, str], environment: dict[str, str]) -> list[Finding]:
    distro = environment.get("ROS_DISTRO", _DISTRO)
    found = []
    if distro != _DISTRO:
        found.append(
            Finding(
                f"ROS {distro} is sourced, this is Jazzy", "open a terminal without its setup.bash"
            )
        )
    found += [
        Finding(f"{module} comes from {path}, before ours", "unset PYTHONPATH, or source no ROS")
        for module, path in foreign.items()
    ]
    return found
