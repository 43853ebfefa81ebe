"""Finds the definition files (.msg, .srv, .action) and what each package needs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

KINDS = ("msg", "srv", "action")

# What rosidl adds to every service and action, beyond what the definition names.
_IMPLIED = {
    "msg": (),
    "srv": ("builtin_interfaces", "service_msgs"),
    "action": ("action_msgs", "builtin_interfaces", "service_msgs", "unique_identifier_msgs"),
}
_PACKAGE_OF_TYPE = re.compile(r"^([a-z][a-z0-9_]*)/[A-Z]\w*")


@dataclass(frozen=True)
class InterfacePackage:
    """One ROS package of definitions.

    Attributes:
        name: ROS package name.
        files: definition files relative to the package's folder, sorted, such as `msg/Route.msg`.
        dependencies: names of the packages its types use directly, sorted.
    """

    name: str
    folder: Path
    files: tuple[Path, ...]
    dependencies: tuple[str, ...]


def find_packages(root: Path) -> list[InterfacePackage]:
    """Return the packages below `root`, each after the packages that it depends on.

    Raises:
        ValueError: packages depend on each other in a circle.
    """
    found = {}
    for folder in sorted(path for path in root.iterdir() if path.is_dir()):
        package = package_of(folder, folder.name)
        if package.files:
            found[package.name] = package
    return in_dependency_order(found)


def package_of(folder: Path, name: str) -> InterfacePackage:
    """Return the package of the definitions in a folder, of which there may be none."""
    found = (path for kind in KINDS for path in folder.glob(f"{kind}/*.{kind}"))
    files = sorted(path for path in found if path.is_file())
    relative = tuple(path.relative_to(folder) for path in files)
    return InterfacePackage(name, folder, relative, tuple(sorted(_dependencies(files) - {name})))


def _dependencies(files: list[Path]) -> set[str]:
    names: set[str] = set()
    for path in files:
        names.update(_IMPLIED[path.suffix[1:]])
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            if match := _PACKAGE_OF_TYPE.match(line.strip()):
                names.add(match.group(1))
    return names


def in_dependency_order(packages: dict[str, InterfacePackage]) -> list[InterfacePackage]:
    """Return packages, each after those of them that it depends on.

    Raises:
        ValueError: They depend on each other in a circle.
    """
    ordered: list[InterfacePackage] = []
    waiting = dict(packages)
    while waiting:
        ready = [p for p in waiting.values() if not waiting.keys() & set(p.dependencies)]
        if not ready:
            raise ValueError(f"packages depend on each other in a circle: {sorted(waiting)}")
        ordered += ready
        for package in ready:
            del waiting[package.name]
    return ordered
