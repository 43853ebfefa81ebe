"""Compiled kernels: a wheel's, for x86-64-v3, which PCs have had since 2015, and another user's."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

TARGET = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
"""The environment in which Numba compiles for that level (x86-64 psABI, section 3.1.1)."""
MARK = Path(__file__).with_name("kernels_are_shipped")
_FLAGS = {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}


def use_shipped_kernels(cpus: Path = Path("/proc/cpuinfo")) -> None:
    """Let Numba compile for that level where a wheel is installed and this CPU has it.

    Numba takes what is compiled only if the level is the same; another CPU compiles for itself, as
    a checkout does. Who may not write beside our modules gets a copy of what is compiled there.
    """
    if not os.access(MARK.parent, os.W_OK):
        with suppress(OSError):
            _give_to_user(MARK.parents[1])
    if not MARK.exists() or not cpus.exists() or not set(TARGET).isdisjoint(os.environ):
        return
    with cpus.open("rb") as file:
        known = file.read(8192).decode(errors="replace").split()
    if set(known) >= _FLAGS:
        os.environ.update(TARGET)
        if "numba" in sys.modules:
            sys.modules["numba.core.config"].reload_config()


def _give_to_user(site: Path) -> None:
    """Copy what is compiled to where Numba looks where it cannot write beside a module."""
    import hashlib
    import shutil

    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
    for folder in {path.parent for path in site.glob("arjuna_*/**/__pycache__/*.nbi")}:
        module = str(folder.parent)
        named = f"{folder.parent.name}_{hashlib.sha1(module.encode()).hexdigest()}"  # noqa: S324
        if not (cache / named).exists():
            shutil.copytree(folder, cache / named, ignore=shutil.ignore_patterns("*.pyc"))
