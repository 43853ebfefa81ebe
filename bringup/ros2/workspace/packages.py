"""The packages of a workspace, as their manifests describe them."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from bringup.ros2.errors import Ros2Error

_IGNORED = ("COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE")
_DEPENDS = re.compile(r"(build|exec|run|buildtool|test|build_export|)_?depend")
NAME = r"[A-Za-z][\w-]*"
SITE = f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
"""The folder of Python's packages below a prefix."""


@dataclass(frozen=True)
class Package:
    """A package of a workspace.

    Attributes:
        kind: Its build type: `ament_python`, `ament_cmake`, ...
    """

    name: str
    folder: Path
    kind: str
    depends: frozenset[str]


def packages_below(folders: Sequence[str | Path]) -> Iterator[Package]:
    """Yield the packages below folders; there are none in a package."""
    for folder in map(Path, folders):
        for here, inside, files in os.walk(folder):
            path = Path(here)
            if set(_IGNORED) & set(files):
                inside.clear()
            elif "package.xml" in files or "setup.py" in files:
                inside.clear()
                yield _package(path)
            inside[:] = sorted(
                n for n in inside if n not in ("build", "install", "log") and n[0] != "."
            )


def _package(folder: Path) -> Package:
    path = folder / "package.xml"
    if not path.is_file():
        return Package(folder.resolve().name, folder, "python", frozenset())
    root = parse_xml(path, read_bytes(path))
    name = (root.findtext("name") or "").strip()
    if not re.fullmatch(NAME, name):
        raise Ros2Error(f"{path}: <name> is '{name}'; valid: letters, digits and _")
    kind = (root.findtext("export/build_type") or "").strip()
    if not kind:
        kind = "ament_python" if (folder / "setup.py").is_file() else "catkin"
    depends = {(e.text or "").strip() for e in root if _DEPENDS.fullmatch(e.tag)}
    return Package(name, folder, kind, frozenset(depends))
