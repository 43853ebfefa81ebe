"""Is all here that the set-up cannot install itself? Standard library only, no root."""

from __future__ import annotations

import ctypes.util
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

OLDEST, NEWEST = (3, 10), (3, 13)
DISK_GIB = 3.0
"""The environment, the compiled messages and pip's cache [GiB]."""


@dataclass(frozen=True)
class Missing:
    """One thing that is not there.

    Attributes:
        packages: The Debian and Ubuntu packages that bring it.
        advice: What to do where no package mends it.
        fatal: Whether the set-up needs it.
    """

    what: str
    packages: tuple[str, ...] = ()
    advice: str = ""
    fatal: bool = True

    @property
    def remedy(self) -> str:
        """The command, or the advice, that mends it."""
        return (
            f"sudo apt-get install -y {' '.join(self.packages)}" if self.packages else self.advice
        )


def check_platform() -> Missing | None:
    """Compiled packages exist for Linux on x86-64 only."""
    if sys.platform == "linux" and platform.machine() in ("x86_64", "AMD64"):
        return None
    here = f"{platform.system()} on {platform.machine()}"
    return Missing(f"Linux on x86-64 (this is {here})", advice="use an x86-64 Linux machine")


def check_python() -> Missing | None:
    """The packages' compiled parts exist for some Python versions only."""
    if OLDEST <= sys.version_info[:2] <= NEWEST:
        return None
    valid = f"3.{OLDEST[1]} to 3.{NEWEST[1]}"
    what = f"Python {valid} ({sys.executable} is {platform.python_version()})"
    return Missing(what, advice="make setup PYTHON=python3.12, or another from that range")


def check_venv() -> Missing | None:
    """Debian and Ubuntu ship Python without the part that makes environments."""
    if all(importlib.util.find_spec(name) for name in ("venv", "ensurepip")):
        return None
    return Missing("Python's venv and ensurepip modules", (f"{_python_package()}-venv",))


def check_headers() -> Missing | None:
    """The message packages compile against Python.h."""
    if (Path(sysconfig.get_path("include")) / "Python.h").is_file():
        return None
    return Missing("Python.h, to compile the message packages", (f"{_python_package()}-dev",))


def check_c() -> Missing | None:
    """The message packages are partly C."""
    if _compiles(os.environ.get("CC", "gcc"), "c", "#include <stdlib.h>\n"):
        return None
    return Missing("a C compiler (gcc), to compile the message packages", ("gcc", "libc6-dev"))


def check_cxx() -> Missing | None:
    """The message packages are partly C++."""
    if _compiles(os.environ.get("CXX", "g++"), "c++", "#include <string>\n"):
        return None
    return Missing("a C++ compiler (g++), to compile the message packages", ("g++",))


def check_disk() -> Missing | None:
    """A disk that fills half way leaves a broken environment."""
    free = shutil.disk_usage(Path.cwd()).free / 2**30
    if free >= DISK_GIB:
        return None
    what = f"{DISK_GIB:g} GiB of free disk ({free:.1f} GiB are free in {Path.cwd()})"
    return Missing(what, advice="free some space, or clone to another disk")


def check_gl() -> Missing | None:
    """Only the simulated camera renders."""
    if any(ctypes.util.find_library(name) for name in ("EGL", "OSMesa")):
        return None
    what = "libEGL or libOSMesa: the simulated camera will be off"
    return Missing(what, ("libegl1", "libgl1-mesa-dri"), fatal=False)


ALWAYS = (check_platform, check_python, check_gl)
TO_INSTALL = (check_venv, check_disk)
TO_COMPILE = (check_c, check_cxx, check_headers)


def find_missing(checks: tuple[Callable[[], Missing | None], ...]) -> list[Missing]:
    """Run checks and return what they miss, in their order."""
    return [missing for missing in (check() for check in checks) if missing is not None]


def explain(missing: list[Missing]) -> list[str]:
    """Return one line for each missing thing, and one command for all of them."""
    lines = [
        f"{'error: missing' if item.fatal else 'warning: no'} {item.what}; {item.remedy}"
        for item in missing
    ]
    packages = [name for item in missing for name in item.packages]
    if len([item for item in missing if item.packages]) > 1:
        lines.append(f"all at once: sudo apt-get install -y {' '.join(packages)}")
    return lines


def _python_package() -> str:
    return f"python3.{sys.version_info[1]}"


def _compiles(command: str, language: str, source: str) -> bool:
    words = command.split()
    if not words or shutil.which(words[0]) is None:
        return False
    run = [*words, "-x", language, "-fsyntax-only", "-"]
    # No shell; the command is the user's own choice of a compiler.
    done = subprocess.run(run, input=source, capture_output=True, text=True, check=False)  # noqa: S603
    return done.returncode == 0
