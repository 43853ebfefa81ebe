"""Python, its environment, the compiled messages, and a sourced ROS that comes first."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 0
_DISTRO = "jazzy"


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield faults of the installation."""
    machine = snapshot.machine
    if not (3, 10) <= machine.python <= (3, 13):
        what = f"Python {'.'.join(map(str, machine.python))} is none of 3.10 to 3.13"
        yield Finding(what, "make setup PYTHON=python3.12")
    if machine.missing:
        what = f"not installed in this Python: {', '.join(machine.missing)}"
        yield Finding(what, "make setup, then .venv/bin/python -m bringup")
    distro = machine.environment.get("ROS_DISTRO", _DISTRO)
    if distro != _DISTRO:
        remedy = "open a terminal without its setup.bash"
        yield Finding(f"ROS {distro} is sourced, this is Jazzy", remedy)
    for module, path in machine.foreign.items():
        what = f"{module} comes from {path}, before ours"
        yield Finding(what, "unset PYTHONPATH, or source no ROS")
