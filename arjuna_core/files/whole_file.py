"""Files read whole, as long as they are files, and no larger than they may be."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError

_JSON_LARGEST = 20_000_000  # [bytes]


def read_bytes(path: Path, largest: int, error: type[InputFileError] = InputFileError) -> bytes:
    """Return a file's content.

    Args:
        path: The file.
        largest: How large it may be [bytes].
        error: The kind of error to raise.

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
        return json.loads(read_bytes(path, _JSON_LARGEST))
    except (ValueError, RecursionError) as error:
        raise InputFileError(path, f"is no JSON: {error}") from error
