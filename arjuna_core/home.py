"""A place for caches and ROS' logs where the user has no home folder that can be written to."""

from __future__ import annotations

import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path


def use_writable_home() -> None:
    """Let caches and ROS' logs go below the folder for temporary files where there is no home.

    As in a container that runs as a user it does not know, and for a service of the system. That
    folder is the user's alone: what is compiled is run from it.
    """
    home = os.path.expanduser("~")  # noqa: PTH111 - Path's raises for a user that is not known
    if not os.access(home, os.W_OK):
        with suppress(OSError):
            home = str(_own_folder())
            os.environ.setdefault("XDG_CACHE_HOME", home)
            os.environ.setdefault("ROS_LOG_DIR", f"{home}/log")
    os.environ.setdefault("HOME", home)


def _own_folder() -> Path:
    """Return a folder that nobody else may write to, made if need be.

    Raises:
        OSError: It cannot be made, or another user has made it.
    """
    folder = Path(tempfile.gettempdir()) / f"arjuna-{os.getuid()}"
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_mode & 0o077 or found.st_uid != os.getuid():
        raise PermissionError(f"'{folder}' is open to others")
    return folder
