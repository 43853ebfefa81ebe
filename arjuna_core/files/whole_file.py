"""Files written whole or not at all, and the folders that they go to."""

from __future__ import annotations

import os
from collections.abc import Callable
from fnmatch import fnmatchcase
from pathlib import Path

from arjuna_core.errors import InputFileError


def emptied_folder(folder: Path, *patterns: str) -> Path:
    """Return a folder, made if need be, without the files whose names fit one of some patterns.

    Raises:
        InputFileError: It cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in folder.iterdir():
            if any(fnmatchcase(path.name, pattern) for pattern in patterns):
                path.unlink()
    except OSError as error:
        problem = f"cannot be written: {error.strerror}; valid: a folder that can be written"
        raise InputFileError(folder, problem) from error
    return folder


def write_atomically(
    path: Path, data: bytes, check: Callable[[Path], None] = lambda part: None
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


def _write_part(path: Path, data: bytes) -> Path:
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


def in_new_file(text: str, suffix: str = ".yaml") -> Path:
    """Return a new file of a text, in the folder of temporary files, for another process."""
    import tempfile

    with tempfile.NamedTemporaryFile(
        "w", prefix="arjuna_", suffix=suffix, delete=False, encoding="utf-8"
    ) as file:
        file.write(text)
    return Path(file.name)
