"""Paths of the files that ship with Arjuna, and folders that the environment names."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_CHECKOUT = Path(__file__).resolve().parents[2]
_INSTALLED = Path(sys.prefix) / "share" / "arjuna"


def shipped_file(relative: str) -> Path:
    """Return the path of a shipped file such as `urdf/arjuna.urdf`, in a checkout or installed."""
    in_checkout = _CHECKOUT / relative
    return in_checkout if in_checkout.exists() else _INSTALLED / relative


def found_or_shipped(name: str) -> str:
    """Return a name as it is, or the shipped file's path where the name is a path to that only."""
    try:
        shipped = shipped_file(name)
        if "/" in name and not Path(name).exists() and shipped.is_file():
            return str(shipped)
    except OSError:  # no file can have such a name: who opens it says so
        pass
    return name


def environment_folders(name: str) -> list[Path]:
    """Return the folders that a variable of the environment lists."""
    return [Path(folder) for folder in os.environ.get(name, "").split(os.pathsep) if folder]


def package_file(package: str, named: str) -> Path | None:
    """Return a file of an installed package's share, or a link there; None where there is none."""
    inside = Path(package).name == package and not Path(named).is_absolute()
    if not package or not inside or ".." in Path(named).parts:
        return None
    folders = environment_folders("AMENT_PREFIX_PATH")
    files = (folder / "share" / package / named for folder in folders)
    return next((file for file in files if file.is_file()), None)
