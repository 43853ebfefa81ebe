"""Packages that a launch file refers to and that are not there: named, and the rest is launched."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from ament_index_python import packages
from ament_index_python.packages import PackageNotFoundError

from launch.launch_context import LaunchContext
from launch.logging import get_logger
from launch.substitution import SubstitutionFailure

_NAMED = re.compile(r"package '([\w-]+)' not found")
_NOWHERE = "/not/installed"
T = TypeVar("T")


class PackageMissing(SubstitutionFailure):
    """A package is not in the ament index."""

    def __init__(self, package: str) -> None:
        self.package = package
        super().__init__(f"package '{package}' not found")


def without_missing(context: LaunchContext, do: Callable[[], T]) -> T:
    """Return what a function of a launch file returns, whose lookups of packages may fail.

    Where it does not catch such a failure itself, it is called again and gets a path that leads
    nowhere: what that is for is left out where it is launched.
    """
    missing: set[str] = set()
    while True:
        try:
            with _pretended(missing):
                return do()
        except PackageNotFoundError as error:
            found = _NAMED.search(str(error))
            if found is None or found[1] in missing:
                raise
            missing.add(found[1])
            report(context, f"package '{found[1]}' not found", error)


def report(context: LaunchContext, problem: str, error: Exception) -> None:
    """Name what is left out, with what to do instead."""
    line = f"{problem}; {context.explain(error)}".rstrip("; ")
    if line in context.problems:
        return
    context.problems.append(line)
    get_logger("launch").error(line)


def left_out(path: Path) -> str:
    """Return the package of a file that is not there for want of that; nothing for other files."""
    from bringup.ros2.verbs.forward import GENERATED

    *_, package = ("", *re.findall(r"/share/([\w-]+)/", str(path)))
    is_ours = any((parent / GENERATED).exists() for parent in path.parents)
    return package if is_ours or str(path).startswith(_NOWHERE) else ""


@contextmanager
def _pretended(missing: Iterable[str]) -> Iterator[None]:
    """Have packages be found that are not there."""
    names = vars(packages)
    real = names["get_resource"]

    def found(kind: str, name: str) -> Any:
        return ("", _NOWHERE) if name in missing else real(kind, name)

    names["get_resource"] = found
    try:
        with warnings.catch_warnings():
            if missing:
                warnings.simplefilter("ignore")
            yield
    finally:
        names["get_resource"] = real
