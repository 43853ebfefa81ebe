"""Disk, memory and cores."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 2


def check(
    snapshot: Snapshot, disk: float = 1.0, memory: float = 0.5, load: float = 3.0
) -> Iterator[Finding]:
    """Yield the resources that the machine lacks.

    Args:
        disk: Least free, an hour's recording with the camera [GiB].
        memory: Least free, for the processes of sim and nav [GiB].
        load: Most processes that want to run, a core: each waits two thirds of the time.
    """
    machine = snapshot.machine
    if machine.disk_free < disk:
        what = f"{machine.disk_free:.1f} GiB of disk are free"
        yield Finding(what, "free some: recordings and maps are cut short on a full disk")
    if machine.memory_free < memory:
        what = f"{machine.memory_free:.1f} GiB of memory are free"
        yield Finding(what, "close other programs, or processes will be killed")
    if machine.load > load:
        what = f"{machine.load:.1f} processes a core want to run"
        yield Finding(what, "close other programs, or run the simulator with --rtf 0.5")
