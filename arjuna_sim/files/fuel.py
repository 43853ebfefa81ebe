"""Models of Fuel, Gazebo's library on the web: where Gazebo keeps those that it has downloaded.

Nothing is downloaded here.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

_VARIABLES = ("GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH")
_HOMES = (Path("~/.gz/fuel"), Path("~/.ignition/fuel"))
_API = re.compile(r"[^/]+/1\.0/([^/]+)/models/([^/]+)(?:/(\d+|tip))?(?:/files)?(?:/(.*))?")
_PAGE = re.compile(r"[^/]+/([^/]+)/fuel/models/([^/]+)(?:/(\d+))?(?:/(.*))?")


def cache_folders() -> tuple[Path, ...]:
    """Return the folders in which Gazebo keeps downloads, those that exist."""
    named = [Path(value) for name in _VARIABLES if (value := os.environ.get(name, ""))]
    found = [*named, *(home.expanduser() for home in _HOMES)]
    return tuple(folder for folder in found if folder.is_dir())


@dataclass(frozen=True)
class FuelUri:
    """An address of a model, or of a file in one.

    Attributes:
        owner: Who has put it there.
        name: The model.
        version: "" for the newest.
        inside: Path in the model.
    """

    owner: str
    name: str
    version: str
    inside: str

    @staticmethod
    def of(address: str) -> FuelUri | None:
        """Return what an address without its scheme names; None where it is not one of Fuel."""
        found = _API.fullmatch(address.rstrip("/")) or _PAGE.fullmatch(address.rstrip("/"))
        if found is None:
            return None
        owner, name, version, inside = found.groups()
        return FuelUri(owner, name, (version or "").removeprefix("tip"), inside or "")

    @property
    def names(self) -> tuple[str, ...]:
        """The names that the model's folder may have."""
        name = self.name
        spelled = (name, name.lower(), name.replace(" ", "_"), name.lower().replace(" ", "_"))
        return tuple(dict.fromkeys(spelled))

    def folders(self, caches: Iterable[Path]) -> list[Path]:
        """Return the folders that hold the model, the wanted version or else the newest first.

        A cache holds `server/owner/models/name/version`, in lower case or as the owner wrote it.
        """
        if any(part in ("", ".", "..") for part in (self.owner, self.name)):
            return []
        spelled = [(self.owner, self.name), (self.owner.lower(), self.name.lower())]
        found = [
            version
            for cache in caches
            for server in sorted(cache.iterdir())
            for owner, name in dict.fromkeys(spelled)
            if (model := server / owner / "models" / name).is_dir()
            for version in sorted(model.iterdir(), key=_number, reverse=True)
        ]
        return sorted(found, key=lambda folder: folder.name != self.version)


def _number(folder: Path) -> int:
    return int(folder.name) if folder.name.isdecimal() else -1
