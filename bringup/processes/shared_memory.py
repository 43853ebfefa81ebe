"""Shared memory that killed processes leave: Fast DDS removes its own only on a clean end."""

from __future__ import annotations

import fcntl
import re
import time
from contextlib import suppress
from pathlib import Path

_FOLDER = Path("/dev/shm")  # noqa: S108
_SEGMENT = re.compile(r"fastrtps_[0-9a-f]{16}")


def remove_leftovers(folder: Path = _FOLDER, young: float = 10.0) -> int:
    """Remove the segments whose processes are gone; each is 4 MB, and a container may have 64.

    A process holds a lock on a file beside its segment for as long as it lives, if not from the
    first; so one of a young age [s] stays.
    """
    names = [path for path in folder.glob("fastrtps_*") if _SEGMENT.fullmatch(path.name)]
    return sum(_removed(path, young) for path in names)


def _removed(segment: Path, young: float) -> bool:
    """Remove a segment and its lock if nobody holds it; return whether that was so."""
    lock = segment.with_name(f"{segment.name}_el")
    with suppress(OSError):  # another user's, held, or gone meanwhile
        if time.time() - segment.stat().st_mtime > young:
            with lock.open("rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                segment.unlink()
                lock.unlink()
                return True
    return False
