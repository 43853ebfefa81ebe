"""Algorithms as published, in C, compiled here as peers to measure by."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

_SOURCES = Path(__file__).parents[1] / "bench"
_COMPILERS = ("cc", "gcc", "clang")


def compiled(name: str, *flags: str) -> ctypes.CDLL | None:
    """Return the library of a source of `tests/bench`; None where no compiler is."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        path, source = Path(folder) / f"{name}.so", _SOURCES / f"{name}.c"
        options = (*flags, "-std=c11", "-shared", "-fPIC")
        subprocess.run([compiler, *options, "-o", path, source, "-lm"], check=True)
        return ctypes.CDLL(str(path))
