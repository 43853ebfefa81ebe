"""Finding what robots and worlds refer to: packages, models and files beside them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

_MODEL_VARIABLES = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
_SCHEMES = ("package", "model")


@dataclass(frozen=True)
class SearchPath:
    """Folders to look in, before those around the file that refers to something.

    Attributes:
        packages: Folders that hold ROS packages, or are packages.
        models: Folders that hold Gazebo models.
    """

    packages: tuple[Path, ...] = ()
    models: tuple[Path, ...] = ()

    @staticmethod
    def of(packages: Iterable[str | Path] = (), models: Iterable[str | Path] = ()) -> SearchPath:
        """Build a search path of names, the ones given first, then those of the environment.

        Args:
            packages: As `packages`; behind them stand the `share` folders of AMENT_PREFIX_PATH.
            models: As `models`; behind them stand GAZEBO_MODEL_PATH and GZ_SIM_RESOURCE_PATH.
        """
        shares = [folder / "share" for folder in _of_environment("AMENT_PREFIX_PATH")]
        known = [folder for name in _MODEL_VARIABLES for folder in _of_environment(name)]
        return SearchPath(
            (*(Path(folder) for folder in packages), *shares),
            (*(Path(folder) for folder in models), *known),
        )

    def package(self, beside: Path, name: str) -> Path | None:
        """Return the folder of a package, or None.

        Args:
            beside: The file that names it.
            name: The package.
        """
        return next(self._folders(beside, name), None)

    def find(self, beside: Path, uri: str) -> Path | None:
        """Resolve a path, or a `file://`, `package://` or `model://` URI, to an existing file.

        A path inside a package or model may not lead out of it.

        Args:
            beside: The file that refers to it.
            uri: What it says.
        """
        scheme, _, rest = uri.strip().rpartition("://")
        if "\0" in rest:
            return None
        if scheme not in _SCHEMES:
            path = beside.parent / rest
            return path if _is_file(path) else None
        name, _, inside = rest.partition("/")
        for folder in self._folders(beside, name):
            path = folder / inside
            if _is_file(path) and path.resolve().is_relative_to(folder.resolve()):
                return path
        return None

    def _folders(self, beside: Path, name: str) -> Iterator[Path]:
        """Yield the folders that a package or model may be."""
        if not name or name in (".", "..") or "\0" in name or len(name) > 255:
            return
        parents = beside.resolve().parents
        candidates = [root for root in self.packages + self.models if root.name == name]
        candidates += [root / name for root in self.packages + self.models]
        candidates += [p for root in self.packages for p in sorted(root.glob(f"*/{_plain(name)}"))]
        candidates += [p for p in parents if p.name == name]
        candidates += [folder / name for p in parents for folder in (p, p / "models")]
        yield from (folder for folder in candidates if folder.is_dir())


def _of_environment(name: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(name, "").split(os.pathsep) if folder]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for the file system
        return False


def _plain(name: str) -> str:
    """Take the special meaning from a name in a glob pattern."""
    return "".join(f"[{c}]" if c in "*?[" else c for c in name)
