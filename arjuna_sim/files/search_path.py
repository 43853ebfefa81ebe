"""Finding what robots and worlds refer to: packages, models and files beside them."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

PACKAGE_VARIABLE = "ROS_PACKAGE_PATH"
MODEL_VARIABLE = "GAZEBO_MODEL_PATH"
_MODEL_VARIABLES = (
    MODEL_VARIABLE,
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_RESOURCE_PATH",
)
_SCHEMES = ("package", "model")
_MANIFESTS = ("package.xml", "model.config")
_MANIFEST_BYTES = 100_000


class EscapeError(ValueError):
    """A path leads out of the package, model or folder that it belongs to."""


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
            packages: As `packages`; behind them stand ROS_PACKAGE_PATH and the `share` folders of
                AMENT_PREFIX_PATH.
            models: As `models`; behind them stand GAZEBO_MODEL_PATH and GZ_SIM_RESOURCE_PATH.
        """
        shares = [folder / "share" for folder in _of_environment("AMENT_PREFIX_PATH")]
        known = [folder for name in _MODEL_VARIABLES for folder in _of_environment(name)]
        named = [Path(folder) for folder in packages] + _of_environment(PACKAGE_VARIABLE)
        return SearchPath((*named, *shares), (*(Path(folder) for folder in models), *known))

    def package(self, beside: Path, name: str) -> Path | None:
        """Return the folder of a package, or None.

        Args:
            beside: The file that names it.
            name: The package.
        """
        return next(self._folders(beside, name), None)

    def find(self, beside: Path, uri: str) -> Path | None:
        """Resolve a path, or a `file://`, `package://` or `model://` URI, to an existing file.

        Args:
            beside: The file that refers to it.
            uri: What it says.

        Returns:
            The file, or None where there is none.

        Raises:
            EscapeError: It leads out of its package or model, or a plain path out of the package
                around the file and out of all folders of this search path.
        """
        scheme, _, rest = uri.strip().rpartition("://")
        if "\0" in rest:
            return None
        if scheme not in _SCHEMES:
            return self._plain_file(beside, rest)
        name, _, inside = rest.partition("/")
        for folder in self._folders(beside, name):
            path = folder / inside
            if not path.resolve().is_relative_to(folder.resolve()):
                raise EscapeError(f"'{uri}' leads out of its {scheme}")
            if _is_file(path):
                return path
        return None

    def _plain_file(self, beside: Path, rest: str) -> Path | None:
        path = beside.parent / rest
        if not _is_file(path):
            return None
        allowed = (home_folder(beside), *self.packages, *self.models)
        if not any(path.resolve().is_relative_to(folder.resolve()) for folder in allowed):
            raise EscapeError(f"'{rest}' leads out of {allowed[0]}; --package-path allows more")
        return path

    def _folders(self, beside: Path, name: str) -> Iterator[Path]:
        """Yield the folders that a package or model may be."""
        if not name or name in (".", "..") or "\0" in name or len(name) > 255:
            return
        parents = beside.resolve().parents
        candidates = [root for root in self.packages + self.models if root.name == name]
        candidates += [root / name for root in self.packages + self.models]
        candidates += [
            p for root in self.packages for p in sorted(root.glob(f"*/{glob.escape(name)}"))
        ]
        candidates += [p for p in parents if p.name == name]
        candidates += [folder / name for p in parents for folder in (p, p / "models")]
        candidates += [p for p in parents if f"<name>{name}</name>" in _manifest(p)]
        yield from (folder for folder in candidates if folder.is_dir())


def home_folder(beside: Path) -> Path:
    """Return the folder that a file's plain paths may not lead out of.

    It is the one that holds the file's package or model, else the parent of the file's folder.
    """
    folder = beside.resolve().parent
    for parent in (folder, *folder.parents):
        if any(_is_file(parent / name) for name in _MANIFESTS) and parent.parent != parent:
            return parent.parent if parent.parent.parent != parent.parent else parent
    return folder.parent if folder.parent.parent != folder.parent else folder


def _manifest(folder: Path) -> str:
    """Return a package's manifest without its spaces, or nothing."""
    try:
        with (folder / _MANIFESTS[0]).open("rb") as file:
            return "".join(file.read(_MANIFEST_BYTES).decode("utf-8", "replace").split())
    except OSError:
        return ""


def _of_environment(name: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(name, "").split(os.pathsep) if folder]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for the file system
        return False
