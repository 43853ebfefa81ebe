"""The modules of the real packages, which have a file for each class."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping
from types import ModuleType

_OTHERS = {"FindPackageShare": "find_package", "ForEach": "for_loop", "Shutdown": "shutdown_action"}
_BEFORE_A_WORD = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def import_by_file(modules: Mapping[ModuleType, Iterable[str]]) -> None:
    """Let what modules have be imported as `launch.actions.timer_action.TimerAction` too.

    That is what they define and some names of others, as an import of `*` takes it.
    """
    for module, names in modules.items():
        own = (k for k, v in vars(module).items() if getattr(v, "__module__", 0) == module.__name__)
        module.__all__ = [*names, *(name for name in own if name[0] != "_")]  # type: ignore[attr-defined]
        for name in module.__all__:
            file = _OTHERS.get(name, _BEFORE_A_WORD.sub("_", name).lower())
            sys.modules.setdefault(f"{module.__name__}.{file}", module)


def import_as(package: str, modules: Mapping[str, ModuleType]) -> None:
    """Let modules be imported by other names below a package too, those of the real one's files."""
    for name, module in modules.items():
        sys.modules.setdefault(f"{package}.{name}", module)
