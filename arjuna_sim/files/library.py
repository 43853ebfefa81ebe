"""The library that clients name resources from: files in folders that the simulator was given."""

from __future__ import annotations

import os
from collections.abc import Iterable
from enum import Enum
from pathlib import Path

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.xml_file import BYTES_MAX

SHIPPED = ("worlds", "urdf", "maps")
WORLD_SUFFIXES = (".world", ".sdf")
_MODEL_FILE = "model.sdf"


class Fault(Enum):
    """Why a resource cannot be used, by the names of simulation_interfaces."""

    UNSUPPORTED_FORMAT = "UNSUPPORTED_FORMAT"
    NO_RESOURCE = "NO_RESOURCE"
    RESOURCE_PARSE_ERROR = "RESOURCE_PARSE_ERROR"
    MISSING_ASSETS = "MISSING_ASSETS"
    UNSUPPORTED_ASSETS = "UNSUPPORTED_ASSETS"
    UNSUPPORTED_ELEMENTS = "UNSUPPORTED_ELEMENTS"
    NOT_FOUND = "RESULT_NOT_FOUND"
    FORBIDDEN = "RESULT_OPERATION_FAILED"


class ResourceError(ArjunaError):
    """A resource that a client named or sent cannot be used."""

    def __init__(self, fault: Fault, problem: str) -> None:
        self.fault = fault
        super().__init__(problem)


def sent_text(text: str) -> str:
    """Return a resource that a client sent.

    Raises:
        ResourceError: It is empty, or longer than what is read.
    """
    if not text.strip():
        raise ResourceError(Fault.NO_RESOURCE, "neither a uri nor a resource_string was given")
    if len(text) > BYTES_MAX:
        problem = f"has {len(text)} characters; at most {BYTES_MAX} are read"
        raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
    return text


class Library:
    """Finds files, and refuses those outside its folders.

    Args:
        folder: Where plain paths start, and may lead, beside the shipped worlds and robots.
        search: Where packages and models are.
    """

    def __init__(self, folder: str | Path, search: SearchPath) -> None:
        self.folder = Path(folder).resolve()
        self.search = search
        self._shipped = tuple(shipped_file(name).resolve() for name in SHIPPED)

    def find(self, uri: str, suffixes: Iterable[str]) -> Path:
        """Return the file that a URI or path names; a model's folder stands for its `model.sdf`.

        Raises:
            ResourceError: There is no such file, it may not be read or has a foreign suffix.
        """
        if "\0" in uri:
            raise ResourceError(Fault.NOT_FOUND, "a name may not hold a NUL")
        try:
            in_package = _scheme(uri) in ("model", "package")
            path = self._in_package(uri) if in_package else self._plain(uri)
        except OSError as error:
            raise ResourceError(Fault.NOT_FOUND, f"{uri[:80]!r}: {error.strerror}") from error
        if path.suffix.lower() not in suffixes:
            valid = ", ".join(suffixes)
            raise ResourceError(Fault.UNSUPPORTED_FORMAT, f"'{uri}' is none of {valid}")
        return path

    def _in_package(self, uri: str) -> Path:
        beside = self.folder / "request"
        for candidate in (uri, f"{uri.rstrip('/')}/{_MODEL_FILE}"):
            try:
                path = self.search.find(beside, candidate)
            except ValueError as error:
                raise ResourceError(Fault.FORBIDDEN, str(error)) from error
            if path is not None:
                return path
        raise ResourceError(Fault.NOT_FOUND, f"'{uri}' does not exist in the model path")

    def _plain(self, uri: str) -> Path:
        if _scheme(uri) not in ("", "file"):
            valid = "a path, file://, model://, package://"
            raise ResourceError(Fault.UNSUPPORTED_FORMAT, f"'{uri}' is unknown; valid: {valid}")
        text = uri.removeprefix("file://")
        allowed = (self.folder, *self._shipped, *self.search.models, *self.search.packages)
        for start in (self.folder, self._shipped[0].parent):
            path = Path(os.path.realpath(start / text))
            if not any(path.is_relative_to(Path(os.path.realpath(root))) for root in allowed):
                continue
            if path.is_dir() and (path / _MODEL_FILE).is_file():
                path = path / _MODEL_FILE
            if path.is_file():
                return path
        inside = Path(os.path.realpath(self.folder / text))
        if not any(inside.is_relative_to(Path(os.path.realpath(root))) for root in allowed):
            problem = f"'{uri}' lies outside of what may be read; valid: below {self.folder}"
            raise ResourceError(Fault.FORBIDDEN, f"{problem} (parameter resource_folder)")
        raise ResourceError(Fault.NOT_FOUND, f"'{uri}' does not exist below {self.folder}")

    def worlds(self) -> tuple[Path, ...]:
        """Return the worlds and maps that are shipped, or lie in the folder or its `worlds`."""
        folders = (self._shipped[0], self.folder, self.folder / "worlds")
        found = [
            path.resolve()
            for folder in folders
            for suffix in WORLD_SUFFIXES
            for path in sorted(folder.glob(f"*{suffix}"))
            if path.is_file()
        ]
        found += sorted(self._shipped[2].glob("*.yaml"))
        return tuple(dict.fromkeys(found))[:1000]

    def models(self) -> tuple[Path, ...]:
        """Return the folders of models that lie in the folder, its `models` or the model path."""
        folders = (self.folder, self.folder / "models", *self.search.models)
        found = [p.parent for folder in folders for p in sorted(folder.glob(f"*/{_MODEL_FILE}"))]
        return tuple(dict.fromkeys(found))[:1000]


def _scheme(uri: str) -> str:
    return uri.partition("://")[0] if "://" in uri else ""
