"""Where maps may be: paths that come over the network stay inside one folder."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote, urlparse

from arjuna_core.errors import ArjunaError

_NAME = 255 - 32  # [bytes] of a name on Linux's file systems, less what files in the making add
_SHOWN = 80


class MapsFolderError(ArjunaError, ValueError):
    """A path leads out of the maps folder, or is none."""


def path_in_folder(folder: str | Path, url: str) -> Path:
    """Return the path that a request names, once it is sure to lie in the maps folder.

    Args:
        folder: The maps folder.
        url: A path, relative to the folder or absolute, or a `file://` URL.

    Raises:
        MapsFolderError: It is empty, too long, of another scheme, or leads out of the folder.
    """
    try:
        parts = urlparse(url)
    except ValueError as error:  # as of http://[
        raise MapsFolderError(f"'{url[:_SHOWN]}' is no path: {error}") from error
    if parts.scheme not in ("", "file"):
        raise MapsFolderError(f"'{url}' has the scheme '{parts.scheme}'; valid: file:// and paths")
    path = unquote(parts.path) if parts.scheme else url
    if not path or "\0" in path:
        raise MapsFolderError(f"{url!r} is no path; valid: a path in {folder}")
    root = Path(folder).resolve()
    try:
        result = (root / path).resolve()
    except (OSError, RuntimeError) as error:  # as of links in a circle
        raise MapsFolderError(f"'{url[:_SHOWN]}' is no path: {error}") from error
    if any(len(part.encode(errors="replace")) > _NAME for part in result.parts):
        raise MapsFolderError(f"'{url[:_SHOWN]}' is no path: a name is longer than {_NAME} bytes")
    if result == root or not result.is_relative_to(root):
        raise MapsFolderError(f"'{url}' lies outside the maps folder {root}")
    return result
