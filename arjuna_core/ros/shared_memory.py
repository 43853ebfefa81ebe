"""Remains of Fast DDS in shared memory, left by killed processes."""

from __future__ import annotations

import fcntl
import re
import time
from contextlib import suppress
from pathlib import Path

_FOLDER = Path("/dev/shm")  # noqa: S108
_SEGMENT, _PORT = re.compile(r"fastrtps_[0-9a-f]{16}"), re.compile(r"fastrtps_port\d+")


def remove_leftovers(folder: Path = _FOLDER, young: float = 10.0, torn: float = 2.0) -> int:
    """Remove segments whose processes are gone, and ports that nobody can open; return how many.

    A segment is 4 MB, and a container may have 64. A process holds a lock on a file beside its
    segment for as long as it lives, if not from the first. A process killed while it made a port
    leaves one for which all others wait without end: at their start, or as they make a publisher.

    Args:
        young: Age below which a segment stays [s].
        torn: Age below which a port that is not yet ready does [s].

    Source: Boost.Interprocess, managed_open_or_create_impl, of the first word's states.
    """
    found = 0
    for path in folder.glob("fastrtps_*"):
        with suppress(OSError):  # another user's, held, or gone meanwhile
            age = time.time() - path.stat().st_mtime
            if _SEGMENT.fullmatch(path.name) and age > young:
                found += _removed(path)
            elif _PORT.fullmatch(path.name) and age > torn and not _is_ready(path):
                path.unlink()
                found += 1
    return found


def _removed(segment: Path) -> bool:
    """Remove a segment and its lock, if nobody holds it."""
    lock = segment.with_name(f"{segment.name}_el")
    with lock.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        segment.unlink()
        lock.unlink()
    return True


def _is_ready(port: Path) -> bool:
    """Return whether a port was made to its end: empty, 0 and 1 are before it."""
    with port.open("rb") as file:
        return int.from_bytes(file.read(4), "little") > 1
