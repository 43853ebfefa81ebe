"""Disk, memory and cores."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_DISK = 1.0  # [GiB] an hour's recording with the camera
_MEMORY = 0.5  # [GiB] what the processes of sim and nav take
_LOAD = 3.0  # processes that want to run, a core: each waits two thirds of the time


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what the machine is short of."""
    machine = snapshot.machine
    found = []
    if machine.disk_free < _DISK:
        what = f"{machine.disk_free:.1f} GiB of disk are free"
        found.append(Finding(what, "free some: recordings and maps are cut short on a full disk"))
    if machine.memory_free < _MEMORY:
        what = f"{machine.memory_free:.1f} GiB of memory are free"
        found.append(Finding(what, "close other programs, or processes will be killed"))
    if machine.load > _LOAD:
        what = f"{machine.load:.1f} processes a core want to run"
        found.append(Finding(what, "close other programs, or run the simulator with --rtf 0.5"))
    return found
