"""`messages`: build your own .msg, .srv and .action files into the environment."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("messages my_msgs", "messages ~/ros2_ws/src")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        help="a package with msg/, srv/ or action/, or a folder with such packages",
    )


def run(arguments: argparse.Namespace) -> int:
    """Build all packages of definitions below the folder; their name is the manifest's or folder's.

    Raises:
        ConfigError: There is none, one cannot be built, or no compiler is installed.
    """
    from rosidl_build.environment import build
    from setuptools.errors import BaseError

    from arjuna_core.errors import ConfigError
    from bringup.terminal import show

    folder = arguments.folder.expanduser()
    if not folder.is_dir():
        raise ConfigError(f"{folder}: there is no such folder")
    try:
        names = build(folder)
    except (ValueError, OSError, BaseError) as error:
        raise ConfigError(str(error)) from error
    show(f"built {', '.join(names)}; 'ros2 interface list' has them")
    return 0
