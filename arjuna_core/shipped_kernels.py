"""What a wheel has with it compiled: for x86-64-v3, which PCs have had since 2015, with AVX2."""

from __future__ import annotations

import os
import sys
from pathlib import Path

TARGET = {
    "NUMBA_CPU_NAME": "x86-64-v3",
    "NUMBA_CPU_FEATURES": "+64bit,+avx,+avx2,+bmi,+bmi2,+cmov,+crc32,+cx16,+cx8,+f16c,+fma,+fxsr,"
    "+lzcnt,+mmx,+movbe,+popcnt,+sahf,+sse,+sse2,+sse3,+sse4.1,+sse4.2,+ssse3,+xsave",
}
"""The environment in which Numba compiles for that level (x86-64 psABI, section 3.1.1)."""
MARK = Path(__file__).with_name("kernels_are_shipped")
_FLAGS = {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
_HEAD = 8192  # [bytes] of /proc/cpuinfo, with the first core in them


def use_shipped_kernels(cpus: Path = Path("/proc/cpuinfo")) -> None:
    """Let Numba compile for that level where a wheel is installed and this CPU has it.

    Numba takes what is compiled only if the level is the same; another CPU compiles for itself, as
    a checkout does.
    """
    if not MARK.exists() or not cpus.exists() or not set(TARGET).isdisjoint(os.environ):
        return
    with cpus.open("rb") as file:
        known = file.read(_HEAD).decode(errors="replace").split()
    if set(known) >= _FLAGS:
        os.environ.update(TARGET)
        if "numba" in sys.modules:
            sys.modules["numba.core.config"].reload_config()
