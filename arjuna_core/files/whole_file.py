"""Files read whole, as long as they are files, and no larger than they may be."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError


def read_bytes(path: Path, largest: int, error: type[InputFileError] = InputFileError) -> bytes:
    """Return a file's content.

    Args:
        largest: How large it may be [bytes].

    Raises:
        InputFileError: It is missing, too large, or no file, as a device; of the kind asked for.
    """
    try:
        if path.exists() and not path.is_file():
            raise error(path, "cannot be read: it is no file")
        size = path.stat().st_size
        if size > largest:
            raise error(path, f"has {size} bytes; at most {largest} are read")
        return path.read_bytes()
    except OSError as cause:
        raise error(path, f"cannot be read: {cause.strerror}") from cause


def head_of(path: Path, count: int) -> bytes:
    """Return the first bytes of a file, none where there is no file.

    Raises:
        OSError: It cannot be read.
    """
    if not path.is_file():
        return b""
    with path.open("rb") as file:
        return file.read(count)


def read_json(path: Path) -> Any:
    """Return a JSON file's content.

    Raises:
        InputFileError: It cannot be read, or is no JSON.
    """
    try:
        # At most 20 MB: a larger file is a mistake or an attack.
        return json.loads(read_bytes(path, 20_000_000))
    except (ValueError, RecursionError) as error:
        raise InputFileError(path, f"is no JSON: {error}") from error


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
