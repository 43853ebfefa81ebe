"""The checks, a file each: `check` yields findings of a snapshot, causes have a lower `RANK`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator

from bringup.doctor.snapshot import Finding, Snapshot

_MODULES = {
    found.name: importlib.import_module(f"{__name__}.{found.name}")
    for found in pkgutil.iter_modules(__path__)
}
CHECKS: dict[str, Callable[[Snapshot], Iterator[Finding]]] = {
    name: _MODULES[name].check for name in sorted(_MODULES, key=lambda name: _MODULES[name].RANK)
}
"""Every check by its name, causes before what follows from them."""
