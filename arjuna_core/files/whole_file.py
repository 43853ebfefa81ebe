"""Files written whole or not at all, and the folders that they go to."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

from arjuna_core.errors import InputFileError

if TYPE_CHECKING:
    from tempfile import TemporaryDirectory


def emptied_folder(folder: Path, *patterns: str) -> Path:
    """Return a folder, made if need be, without the files whose names fit one of some patterns.

    Raises:
        InputFileError: It cannot be written.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for path in folder.iterdir():
            if any(fnmatchcase(path.name, pattern) for pattern in patterns):
                path.unlink()
    return folder


@contextmanager
def writing(path: Path, error: type[InputFileError] = InputFileError) -> Iterator[None]:
    """Raise an error that names a file or folder where what is done cannot write.

    Raises:
        InputFileError: It cannot be written; of the kind given as `error`.
    """
    try:
        yield
    except OSError as cause:
        problem = f"cannot be written: {cause.strerror}; valid: a folder that can be written"
        raise error(path, problem) from cause


def write_atomically(
    path: Path, data: bytes | memoryview, check: Callable[[Path], None] = lambda part: None
) -> None:
    """Write a file so that its path holds the old content or the new, never half of it.

    The data go to a file beside it, are forced to disk and checked, and only then take the name.

    Args:
        check: Reads the written file back and raises what forbids to keep it.

    Raises:
        OSError: It cannot be written.
    """
    part = _write_part(path, data)
    check(part)
    part.replace(path)
    _force_folder(path.parent)


def _write_part(path: Path, data: bytes | memoryview) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)  # a link there would lead the data elsewhere
    with part.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    return part


def _force_folder(folder: Path) -> None:
    """Force the new name to disk, as well as its file."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def own_folder(kind: str, parent: Path | None = None) -> TemporaryDirectory[str]:
    """Return a folder for this process's files of a kind, removed at its end at the latest.

    Those of processes that were killed, or became another program that has ended, are removed.
    """
    import tempfile

    parent = parent or Path(tempfile.gettempdir())
    for left in parent.glob(f"arjuna-{kind}-*-*"):
        process = left.name.removeprefix(f"arjuna-{kind}-").partition("-")[0]
        if not Path(f"/proc/{process}").exists() and left.stat().st_uid == os.getuid():
            shutil.rmtree(left, ignore_errors=True)
    return tempfile.TemporaryDirectory(prefix=f"arjuna-{kind}-{os.getpid()}-", dir=parent)
