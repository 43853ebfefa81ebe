"""The checks, a file each: `check` yields findings of a snapshot, causes have a lower `RANK`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator

from bringup.doctor.snapshot import Finding, Snapshot

Check = Callable[[Snapshot], Iterator[Finding]]


def find() -> dict[str, Check]:
    """Return every check of this folder by its name, causes before what follows from them."""
    names = [found.name for found in pkgutil.iter_modules(__path__)]
    modules = {name: importlib.import_module(f"{__name__}.{name}") for name in names}
    return {name: modules[name].check for name in sorted(names, key=lambda n: modules[n].RANK)}


CHECKS = find()
