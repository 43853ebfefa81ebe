"""Searching the files that robots and worlds refer to: packages, models and files beside them."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import head_of
from arjuna_core.files.shipped import environment_folders

_VARIABLES = ("GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH")
_HOMES = (Path("~/.gz/fuel"), Path("~/.ignition/fuel"))
_API = re.compile(r"[^/]+/1\.0/([^/]+)/models/([^/]+)(?:/(\d+|tip))?(?:/files)?(?:/(.*))?")
_PAGE = re.compile(r"[^/]+/([^/]+)/fuel/models/([^/]+)(?:/(\d+))?(?:/(.*))?")
PACKAGE_VARIABLE = "ROS_PACKAGE_PATH"
MODEL_VARIABLE = "GAZEBO_MODEL_PATH"
RESOURCE_VARIABLES = (
    MODEL_VARIABLE,
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_RESOURCE_PATH",
)
_SCHEMES = ("package", "model")
_WEB = ("http", "https")
_MODELS = (Path("~/.gazebo/models"), Path("/usr/share/gazebo-11/models"))
_TAIL_MIN = 2  # parts of a path that has to be found elsewhere: a folder and a file
MANIFESTS = ("package.xml", "model.config")
_FILES = (".sdf", ".world", ".urdf")
_SDF = re.compile(r"<sdf(?:\s+version=[\"']([\d.]+)[\"'])?[^>]*>\s*([^<]+?)\s*</sdf>")


def cache_folders() -> tuple[Path, ...]:
    """Return the folders in which Gazebo keeps downloads, those that exist."""
    named = [Path(value) for name in _VARIABLES if (value := os.environ.get(name, ""))]
    found = [*named, *(home.expanduser() for home in _HOMES)]
    return tuple(folder for folder in found if folder.is_dir())


def _number(folder: Path) -> int:
    return int(folder.name) if folder.name.isdecimal() else -1


class EscapeError(ValueError):
    """A path leads out of the package, model or folder that it belongs to."""


@dataclass(frozen=True)
class SearchPath:
    """Folders to look in, before those around the file that refers to something.

    Attributes:
        packages: Folders that hold ROS packages, or are packages.
        models: Folders that hold Gazebo models.
        caches: Folders in which Gazebo keeps what it has downloaded from Fuel.
    """

    packages: tuple[Path, ...] = ()
    models: tuple[Path, ...] = ()
    caches: tuple[Path, ...] = ()

    @staticmethod
    def of(packages: Iterable[str | Path] = (), models: Iterable[str | Path] = ()) -> SearchPath:
        """Build a search path of names, the ones given first, then those of the environment.

        Args:
            packages: As `packages`; behind them stand ROS_PACKAGE_PATH and the `share` folders of
                AMENT_PREFIX_PATH.
            models: As `models`; behind them stand GAZEBO_MODEL_PATH and GZ_SIM_RESOURCE_PATH, and
                the folders in which Gazebo itself keeps models.
        """
        shares = [folder / "share" for folder in environment_folders("AMENT_PREFIX_PATH")]
        known = [folder for name in RESOURCE_VARIABLES for folder in environment_folders(name)]
        named = [Path(folder) for folder in packages] + environment_folders(PACKAGE_VARIABLE)
        own = [found for folder in _MODELS if (found := folder.expanduser()).is_dir()]
        return SearchPath(
            (*named, *shares), (*(Path(folder) for folder in models), *known, *own), cache_folders()
        )

    def package(self, beside: Path, name: str) -> Path | None:
        """Return the folder of a package, or None: of those of its name one that has a manifest."""
        first = None
        for folder in self._folders(beside, name):
            if is_file(folder / MANIFESTS[0]):
                return folder
            first = first or folder
        return first

    def find(self, beside: Path, uri: str) -> Path | None:
        """Resolve a path, or a `file://`, `package://` or `model://` URI, to an existing file.

        Args:
            beside: The file that refers to it.

        Raises:
            EscapeError: It leads out of its package or model, or a plain path out of the package
                around the file and out of all folders of this search path.
        """
        scheme, _, rest = unquote(uri.strip()).rpartition("://")
        if "\0" in rest:
            return None
        if scheme in _WEB:
            return self._of_fuel(beside, rest)
        if scheme not in _SCHEMES:
            return self._plain_file(beside, rest)
        name, _, inside = rest.lstrip("/").partition("/")
        for folder in self._folders(beside, name):
            path = folder / inside
            if not path.resolve().is_relative_to(folder.resolve()):
                raise EscapeError(f"'{uri}' leads out of its {scheme}")
            if is_file(path):
                return path
        return None

    def find_model(self, beside: Path, uri: str) -> Path | None:
        """Return the SDF file of a model: the newest of its manifest's, or `model.sdf`.

        Args:
            uri: Of its folder, or of the file itself.

        Raises:
            EscapeError: As `find`.
        """
        uri = uri.rstrip("/")
        if uri.lower().endswith(_FILES) and (path := self.find(beside, uri)) is not None:
            return path
        for start in (uri, *((f"model://{uri}",) if "://" not in uri else ())):
            manifest = self.find(beside, f"{start}/{MANIFESTS[1]}")
            listed = [] if manifest is None else _SDF.findall(_text(manifest))
            names = [name for _, name in sorted(listed, key=_version, reverse=True)]
            for name in (*names, "model.sdf"):
                if (path := self.find(beside, f"{start}/{name}")) is not None:
                    return path
        return None

    def _of_fuel(self, beside: Path, rest: str) -> Path | None:
        """Return a file of a model on Fuel: downloaded by Gazebo, or a model of that name here."""
        address = rest.rstrip("/")
        found = _API.fullmatch(address) or _PAGE.fullmatch(address)
        if found is None:
            return None
        owner, name, version, inside = (part or "" for part in found.groups())
        for folder in self._downloads(owner, name, version):
            path = folder / inside
            if is_file(path) and path.resolve().is_relative_to(folder.resolve()):
                return path
        spelled = (name, name.lower(), name.replace(" ", "_"), name.lower().replace(" ", "_"))
        here = (self.find(beside, f"model://{each}/{inside}") for each in dict.fromkeys(spelled))
        return next((path for path in here if path is not None), None)

    def _downloads(self, owner: str, name: str, version: str) -> list[Path]:
        """Return the folders that hold a model, the wanted version or else the newest first.

        A cache holds `server/owner/models/name/version`, in lower case or as the owner wrote it.
        """
        if any(part in ("", ".", "..") for part in (owner, name)):
            return []
        found = [
            each
            for cache in self.caches
            for server in sorted(cache.iterdir())
            for who, what in dict.fromkeys([(owner, name), (owner.lower(), name.lower())])
            if (model := server / who / "models" / what).is_dir()
            for each in sorted(model.iterdir(), key=_number, reverse=True)
        ]
        return sorted(found, key=lambda folder: folder.name != version)

    def _plain_file(self, beside: Path, rest: str) -> Path | None:
        """Return what a path leads to: from the file's folder, or from one that holds it."""
        allowed = (home_folder(beside), *self.packages, *self.models)
        escaped = False
        for path in self._candidates(beside, rest):
            if not is_file(path):
                continue
            if any(path.resolve().is_relative_to(folder.resolve()) for folder in allowed):
                return path
            escaped = True
        if escaped:
            raise EscapeError(f"'{rest}' leads out of {allowed[0]}; --package-path allows more")
        return None

    def _candidates(self, beside: Path, rest: str) -> Iterator[Path]:
        """Yield the files that a path may name, as Gazebo finds them from any working directory."""
        yield beside.parent / rest
        home = home_folder(beside)
        above = [p for p in beside.resolve().parents[1:] if p.is_relative_to(home)]
        roots = [*above, *(r for root in self.models for r in (root, root.parent)), *self.packages]
        parts = PurePosixPath(rest).parts
        for first in range(int(parts[:1] == ("/",)), max(1, len(parts) - _TAIL_MIN + 1)):
            if ".." not in parts:
                yield from (root.joinpath(*parts[first:]) for root in roots)

    def _folders(self, beside: Path, name: str) -> Iterator[Path]:
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
        candidates += sorted(_beside(beside, name))
        candidates += [p for p in parents if f"<name>{name}</name>" in _manifest(p)]
        yield from (folder for folder in candidates if folder.is_dir())


def _beside(beside: Path, name: str) -> Iterator[Path]:
    """Yield the folders of a model that the packages around a file's package hold."""
    home = home_folder(beside)
    if len(home.parts) > _TAIL_MIN:
        yield from home.glob(f"*/models/{glob.escape(name)}")


def home_folder(beside: Path) -> Path:
    """Return the folder that a file's plain paths may not lead out of.

    It is the one that holds the file's package or model, else the parent of the file's folder.
    """
    folder = beside.resolve().parent
    for parent in (folder, *folder.parents):
        if any(is_file(parent / name) for name in MANIFESTS) and parent.parent != parent:
            return parent.parent if parent.parent.parent != parent.parent else parent
    return folder.parent if folder.parent.parent != folder.parent else folder


def _manifest(folder: Path) -> str:
    return "".join(_text(folder / MANIFESTS[0]).split())


def _text(path: Path) -> str:
    try:
        # A hostile manifest may be large: its first 100 kB are read.
        return head_of(path, 100_000).decode("utf-8", "replace")
    except InputFileError:
        return ""


def _version(listed: tuple[str, str]) -> list[int]:
    return [int(number) for number in listed[0].split(".") if number]


def is_file(path: Path) -> bool:
    """Return whether a path is a file; no name is one that is too long for the file system."""
    try:
        return path.is_file()
    except OSError:
        return False
