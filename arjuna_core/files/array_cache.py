"""Arrays that take long to compute, kept in the user's cache folder by what they are made of."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import io
import os
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.whole_file import write_atomically

_BYTES_MAX = 500_000_000  # of all that is kept; what was not used for longest goes first
_FILE_BYTES_MAX = 200_000_000
_DAMAGED = (OSError, EOFError, ValueError, LookupError, zipfile.BadZipFile, zlib.error)
Arrays = tuple[NDArray[Any], ...]
"""Which depend on nothing but what they are made of."""


def cache_folder() -> Path:
    """Return the folder of the user's for what can be made again; it may not exist yet."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "arjuna"


@cache
def made_by(*modules: str) -> bytes:
    """Return the code of modules, by their files, and the versions of what they compute with."""
    versions = f"{np.__version__} {scipy.__version__}".encode()
    return versions + b"".join(Path(name).read_bytes() for name in modules)


def content_of(value: Any) -> bytes:
    """Return a digest of data classes, containers, arrays and plain values in one another.

    Fields whose names begin with an underscore hold what was computed of the others.

    Raises:
        TypeError: It holds anything else.
    """
    digest = hashlib.sha256()
    for part in _parts(value):
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.digest()


def _parts(value: Any) -> Iterator[bytes]:
    yield type(value).__name__.encode()
    inside: Sequence[Any] = ()
    if isinstance(value, np.ndarray | np.generic):
        yield f"{value.dtype.str} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif dataclasses.is_dataclass(value):
        names = (field.name for field in dataclasses.fields(value))
        inside = [getattr(value, name) for name in names if not name.startswith("_")]
    elif isinstance(value, Mapping):
        inside = [each for pair in value.items() for each in pair]
    elif isinstance(value, Set):
        inside = sorted(value)
    elif isinstance(value, list | tuple):
        inside = value
    elif value is None or isinstance(value, bool | int | float | str | bytes | Path | Enum):
        yield repr(value).encode()
    else:
        raise TypeError(f"{type(value).__name__} is neither data nor plain")
    yield str(len(inside)).encode()
    for each in inside:
        yield from _parts(each)


def cached(kind: str, made_of: Sequence[bytes], make: Callable[[], Arrays]) -> Arrays:
    """Return arrays that were made before of the same content, or make them.

    Args:
        kind: Name of what they are; a folder in the cache.
        made_of: All that they depend on, with the code that makes them.
        make: Makes them; what it raises is raised.
    """
    digest = hashlib.sha256(kind.encode())
    for part in made_of:
        digest.update(len(part).to_bytes(8, "little") + part)
    path = cache_folder() / kind / f"{digest.hexdigest()}.npz"
    with contextlib.suppress(InputFileError, *_DAMAGED):
        if path.exists():  # a reader's error would look for the name that is nearest
            content = read_bytes(path, _FILE_BYTES_MAX)
            with np.load(io.BytesIO(content), allow_pickle=False) as found:
                arrays = tuple(found[f"arr_{i}"] for i in range(len(found.files)))
            os.utime(path)  # it was used now
            return arrays
    arrays = make()
    with contextlib.suppress(InputFileError, OSError):  # a folder that cannot be written
        _keep(path, arrays)
    return arrays


def _keep(path: Path, arrays: Arrays) -> None:
    out = io.BytesIO()
    np.savez(out, *arrays)
    if out.tell() > _FILE_BYTES_MAX:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, out.getbuffer())
    kept = sorted((each.stat().st_mtime, each) for each in path.parent.glob("*.npz"))
    total = sum(each.stat().st_size for _, each in kept)
    for _, each in kept:
        if total <= _BYTES_MAX:
            break
        total -= each.stat().st_size
        each.unlink(missing_ok=True)
