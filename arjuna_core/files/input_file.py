"""The one door through which files are read: regular files, bounded in size, growth and time."""

from __future__ import annotations

import bz2
import difflib
import gzip
import io
import json
import lzma
import os
import stat
import time
import zlib
from collections.abc import Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

from arjuna_core.errors import InputFileError

UNPACKERS: dict[str, Any] = {
    ".xz": partial(lzma.open, format=lzma.FORMAT_XZ),
    ".gz": gzip.open,
    ".bz2": bz2.open,
}
"""What unpacks text, by the suffix of its file."""
UNPACKING = (OSError, EOFError, lzma.LZMAError, zlib.error)
"""What is raised where packed text is damaged or cut short."""
MESH_BYTES_MAX = 60_000_000
"""Size of a mesh or a texture [bytes]: what still loads within a few seconds and 500 MB."""
_Error = type[InputFileError]


def open_file(
    path: Path, error: _Error = InputFileError, largest: int | None = None
) -> io.BufferedReader:
    """Return a regular file, open for reading; one that is read whole has a largest size [bytes].

    Raises:
        InputFileError: It is missing, too large, or no regular file, as a pipe or a device; of the
            kind given as `error`.
    """
    try:
        # Devices act when they are opened, so the kind is known before; and again of what was
        # opened, which may have been put there meanwhile: by that time nothing can block.
        _check_kind(path, path.stat(), error)
        file = open(path, "rb", opener=_descriptor_of)  # noqa: SIM115 - the one place
    except (OSError, ValueError) as cause:  # ValueError: a NUL in the name
        reason = getattr(cause, "strerror", None) or cause
        hint = _nearest_file(path) + error.origin if isinstance(cause, FileNotFoundError) else ""
        raise error(path, f"cannot be read: {reason}{hint}") from cause
    status = os.fstat(file.fileno())
    try:
        _check_kind(path, status, error)
        if largest is not None and status.st_size > largest:
            raise error(path, f"has {status.st_size} bytes; at most {largest} are read")
        on_disk = status.st_blocks * 512  # 0 where a file system does not say
        if on_disk:
            check_growth(path, on_disk, status.st_size, 1 << 30, error)
    except InputFileError:
        file.close()
        raise
    return file


def _nearest_file(path: Path, most: int = 1000) -> str:
    """Return which name in a missing file's folder, of so many at most, is nearest to its own."""
    try:
        with os.scandir(path.parent) as entries:
            names = [entry.name for entry in islice(entries, most)]
    except OSError:
        return ""
    near = difflib.get_close_matches(path.name, sorted(names), 1)
    return f"; the nearest is '{path.parent / near[0]}'" if near else ""


def _descriptor_of(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


def _check_kind(path: Path, status: os.stat_result, error: _Error) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise error(path, "cannot be read: it is no file; valid: a regular file")


def read_bytes(
    path: Path, largest: int = 2**20, error: _Error = InputFileError, within: float = 30.0
) -> bytes:
    """Return a file's content.

    Args:
        largest: How large it may be [bytes].
        within: How long reading it may take [s].

    Raises:
        InputFileError: As of `open_file`, it takes too long, or it is only a pointer of Git LFS.
    """
    end, parts, size = time.monotonic() + within, [], 0
    with open_file(path, error, largest) as file:
        try:
            while part := file.read(min(1 << 24, largest + 1 - size)):
                parts.append(part)
                size += len(part)
                if size > largest:  # it grows, or its size is not known, as below /proc
                    raise error(path, f"has more than {largest} bytes, which are read at most")
                if time.monotonic() > end:
                    raise error(path, f"cannot be read within {within:g} s")
        except OSError as cause:
            raise error(path, f"cannot be read: {cause.strerror}") from cause
    content = parts[0] if len(parts) == 1 else b"".join(parts)
    if content.startswith(b"version https://git-lfs"):
        raise error(path, "is a pointer of Git LFS; 'git lfs pull' in its folder fetches the file")
    return content


def read_text(path: Path, largest: int = 2**20, error: _Error = InputFileError) -> str:
    """Return a text file's content.

    Raises:
        InputFileError: As of `read_bytes`, or it is no UTF-8.
    """
    try:
        return read_bytes(path, largest, error).decode("utf-8")
    except UnicodeDecodeError as reason:
        raise error(path, "is no UTF-8 text") from reason


def head_of(path: Path, count: int, error: _Error = InputFileError) -> bytes:
    """Return the first bytes of a file; none where there is no file.

    Raises:
        InputFileError: As of `open_file`.
    """
    if not os.path.lexists(path):
        return b""
    with open_file(path, error) as file:
        return file.read(count)


def is_xml(path: Path) -> bool:
    """Return whether a file begins as XML does; its reader says why one cannot be read."""
    try:
        return head_of(path, 1 << 20).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")
    except InputFileError:
        return False


def read_json(path: Path) -> Any:
    """Return a JSON file's content: at most 20 MB, and a million values.

    Raises:
        InputFileError: It cannot be read, is no JSON or has too many values.
    """
    data, most = read_bytes(path, 20_000_000), 1_000_000
    if sum(map(data.count, (b",", b"[", b"{"))) > most:
        raise InputFileError(path, f"has more than {most} values")
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputFileError(path, f"is no JSON: {error}") from error


class _InParts:
    """A file that gives 8 kB at once: gzip asks for 128 from Python 3.12 on, and unpacks them."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def read(self, size: int) -> bytes:
        """Return bytes of the file; none at its end."""
        return self._file.read(min(size, 1 << 13))


def read_lines(path: Path, longest: int = 1 << 20) -> Iterator[tuple[bytes, float]]:
    """Yield a text file's lines, unpacked by its suffix, each with the share (0..1) that is read.

    Args:
        longest: How long a line may be [bytes].

    Raises:
        InputFileError: As of `open_file`; a line is too long, or the text unpacks to far more than
            any log does.
        UNPACKING: It is damaged or cut short.
    """
    unpack = UNPACKERS.get(path.suffix.lower())
    with open_file(path) as raw:
        text: BinaryIO = raw if unpack is None else unpack(_InParts(raw))
        all_of_it, size = max(1, os.fstat(raw.fileno()).st_size), 0
        while line := text.readline(longest + 1):
            size += len(line)
            if len(line) > longest:
                raise InputFileError(path, f"has a line of more than {longest} bytes")
            if unpack is not None:
                check_growth(path, raw.tell(), size, 1 << 23)
            yield line, raw.tell() / all_of_it


def check_growth(
    path: Path, packed: int, size: int, always: int, error: _Error = InputFileError
) -> None:
    """Refuse data that unpack to far more than they were: bombs, and files that are a hole.

    Args:
        packed: How large they were [bytes].
        size: How large they are [bytes].
        always: How large they may be in any case [bytes].

    Raises:
        InputFileError: They are larger.
    """
    most = 200  # times; logs of a robot that stands still come to about 100, bombs to 1000 or more
    if size > always and size > most * packed:
        problem = (
            f"{packed} bytes of it unpack to {size} or more; valid: up to {most} times as many"
        )
        raise error(path, problem)
