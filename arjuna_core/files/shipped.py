"""Paths of the files that ship with Arjuna: robots, worlds, maps, parameters."""

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
    if "/" not in name or os.path.exists(name):  # noqa: PTH110 - too long a name does not exist
        return name
    shipped = shipped_file(name)
    return str(shipped) if shipped.is_file() else name
