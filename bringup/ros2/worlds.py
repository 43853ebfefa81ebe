"""Gazebo's worlds, by the words and names that launch files give."""

from __future__ import annotations

from pathlib import Path

from arjuna_core.errors import nearest
from arjuna_core.files.shipped import environment_folders, shipped_file
from arjuna_sim.files.search_path import RESOURCE_VARIABLES
from bringup.ros2.errors import Ros2Error

ENDINGS = (".world", ".sdf", ".sdf.xacro", ".yaml")
"""Of worlds' files."""


def world_of(name: str) -> Path:
    """Return the file of a world: a path, or a name where Gazebo looks, in a package or shipped.

    Raises:
        Ros2Error: There is none.
    """
    file = name if name.endswith(ENDINGS) else f"{name}.world"
    prefixes, shipped = environment_folders("AMENT_PREFIX_PATH"), shipped_file("worlds")
    shares = [share for one in prefixes for share in sorted(one.glob("share/*/"))]
    shares[:0] = [folder for name in RESOURCE_VARIABLES for folder in environment_folders(name)]
    named = (share / n for share in shares for n in (file, f"worlds/{file}"))
    for path in (Path(name), *named, shipped / file):
        if path.is_file():
            return path.resolve()
    there = [path.stem if file != name else path.name for path in shipped.glob("*.world")]
    raise Ros2Error(f"there is no world '{name}'; {nearest(Path(name).name, there)}")
