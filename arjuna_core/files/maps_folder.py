"""The folders of files that a client may name: one, and for maps the user's home too."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote, urlparse

from arjuna_core.errors import ArjunaError

_NAME = 255 - 32  # [bytes] of a name on Linux's file systems, less what files in the making add


class MapsFolderError(ArjunaError, ValueError):
    """A path leads out of the folders that are open to clients, or is none."""


def path_in_folder(folder: str | Path, url: str) -> Path:
    """Return the path that a request names, once it is sure to lie in the maps folder.

    Args:
        url: A path, relative to the folder or absolute, or a `file://` URL.

    Raises:
        MapsFolderError: It is empty, too long, of another scheme, or leads out of the folder.
    """
    root = Path(folder).resolve()
    result = _resolved(root, url)
    if result == root or not result.is_relative_to(root):
        raise MapsFolderError(f"'{url}' lies outside the maps folder {root}")
    return result


def map_path(folder: str | Path, url: str, suffix: str = "") -> Path:
    """Return the path of a map or graph that a request names, links followed.

    Args:
        url: A path, relative to the folder, absolute or from `~/`, or a `file://` URL.
        suffix: Ends the file's name; added where it lacks.

    Raises:
        MapsFolderError: It is empty, too long, of another scheme, or lies neither in the maps
            folder nor, outside hidden folders, in the user's home or the working folder.
    """
    root = Path(folder).resolve()
    named = url if url.endswith(suffix) else f"{url}{suffix}"
    result = _resolved(root, named)
    if result != root and result.is_relative_to(root):
        return result
    open_folders = _open_folders()
    for allowed in open_folders:
        below = result.relative_to(allowed).parts if result.is_relative_to(allowed) else ()
        if below and not any(part.startswith(".") for part in below):
            return result
    listed = ", ".join(dict.fromkeys(str(each) for each in (root, *open_folders)))
    problem = f"'{url}' is no place for maps; valid: paths in {listed}, none of them hidden"
    raise MapsFolderError(problem)


def _open_folders() -> list[Path]:
    """Return the user's home and the working folder; never the whole disk."""
    found = []
    for folder in (Path.home, Path.cwd):
        with suppress(RuntimeError, OSError):  # there may be none
            found.append(folder().resolve())
    return [folder for folder in dict.fromkeys(found) if folder != folder.parent]


def _resolved(root: Path, url: str) -> Path:
    try:
        parts = urlparse(url)
    except ValueError as error:  # as of http://[
        raise MapsFolderError(f"'{url}' is no path: {error}") from error
    if parts.scheme not in ("", "file"):
        raise MapsFolderError(f"'{url}' has the scheme '{parts.scheme}'; valid: file:// and paths")
    path = unquote(parts.path) if parts.scheme else url
    if not path or "\0" in path:
        raise MapsFolderError(f"{url!r} is no path; valid: a path in {root}")
    try:
        start = Path(path).expanduser() if path.startswith("~/") else Path(path)
        result = (root / start).resolve()
    except (OSError, RuntimeError) as error:  # as of links in a circle
        raise MapsFolderError(f"'{url}' is no path: {error}") from error
    if any(len(part.encode(errors="replace")) > _NAME for part in result.parts):
        raise MapsFolderError(f"'{url}' is no path: a name is longer than {_NAME} bytes")
    return result
