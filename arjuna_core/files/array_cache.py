"""Arrays that take long to compute, kept in the user's cache folder by what they are made of."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import zipfile
import zlib
from collections.abc import Callable, Sequence
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
_FILE_BYTES_MAX = 100_000_000
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
    write_atomically(path, out.getvalue())
    kept = sorted((each.stat().st_mtime, each) for each in path.parent.glob("*.npz"))
    total = sum(each.stat().st_size for _, each in kept)
    for _, each in kept:
        if total <= _BYTES_MAX:
            break
        total -= each.stat().st_size
        each.unlink(missing_ok=True)
