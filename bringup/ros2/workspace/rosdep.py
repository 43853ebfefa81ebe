"""`rosdep`: whether what the packages of a workspace need is here; it installs nothing."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from ament_index_python import get_packages_with_prefixes

from arjuna_core.errors import ArjunaError
from bringup.ros2.main import become_real
from bringup.ros2.prefix import add_prefix
from bringup.ros2.verbs.forward import PROGRAMS, remedy
from bringup.ros2.verbs.remedies import PIP
from bringup.ros2.workspace.packages import Package, packages_below

_BUILD = re.compile(
    r"ament_\w+|rosidl_\w+|catkin|message_generation|message_runtime|roslaunch"
    r"|ros2(bag|cli|launch|run|topic)|python3?(-dev|-pip|-setuptools|-pytest)?|ros_environment"
)
"""What builds, tests and starts packages: `colcon` and `ros2` do without it, or are that."""
_MODULES = {"opencv": "cv2", "pil": "PIL", "yaml": "yaml", "pyyaml": "yaml", "serial": "serial"}
_NOTHING = ("fix-permissions", "init", "update")
_COMMANDS = ("check", "install", "keys", *_NOTHING)


def run() -> NoReturn:
    """Run rosdep: that of a sourced ROS where there is one, else this."""
    become_real("rosdep")
    sys.exit(main(sys.argv[1:]))


def main(words: Sequence[str]) -> int:
    """Say what the packages below folders lack; return 1 if that is something, but with `-r`."""
    given, _ = _parser().parse_known_args(words)
    if given.command in _NOTHING:
        print(f"nothing to {given.command}: 'rosdep check' looks at what is installed")
        return 0
    try:
        packages = list(packages_below([Path(each) for each in given.from_paths or ["."]]))
    except ArjunaError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    if not packages:
        sys.stderr.write(f"no packages below {' '.join(given.from_paths or ['.'])}\n")
        return 1
    needs = _needs(packages, set(" ".join(given.skip_keys).split()))
    if given.command == "keys":
        print("\n".join(sorted(needs)))
        return 0
    return _report(needs, given.command) and not given.r


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("rosdep", description=__doc__, allow_abbrev=False)
    parser.add_argument("command", choices=sorted(_COMMANDS))
    parser.add_argument("--from-paths", "--from-path", nargs="+", metavar="FOLDER")
    for switch in "airynqstv":  # clusters of them too, as -iry
        parser.add_argument(f"-{switch}", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--skip-keys", action="append", default=[], metavar="KEYS")
    return parser


def _needs(packages: Sequence[Package], skipped: set[str]) -> dict[str, list[str]]:
    """Return what packages need that is none of them, and which ones need it."""
    own = {package.name for package in packages} | skipped
    needs: dict[str, list[str]] = {}
    for package in packages:
        for key in sorted(package.depends - own):
            needs.setdefault(key, []).append(package.name)
    return needs


def _report(needs: dict[str, list[str]], command: str) -> bool:
    """Say what is lacking; return whether that is something."""
    add_prefix()
    here = {*get_packages_with_prefixes(), *(package for package, _ in PROGRAMS)}
    lacking = {key: names for key, names in sorted(needs.items()) if not _is_here(key, here)}
    for key, names in lacking.items():
        sys.stderr.write(f"{key} (of {', '.join(names)}) is not here; {_remedy(key)}\n")
    if lacking:
        sys.stderr.write("'colcon build' builds what does without\n")
        return True
    is_check = command == "check"
    text = "All system dependencies have been satisfied"
    print(text if is_check else "#All required rosdeps installed successfully")
    return False


def _is_here(key: str, packages: set[str]) -> bool:
    if key in packages or _BUILD.fullmatch(key):
        return True
    module = _module(key) or key
    return module.isidentifier() and find_spec(module) is not None


def _module(key: str) -> str:
    """Return the module of Debian's `python3-NAME`, "" for other keys."""
    name = re.sub(r"^python3?-|-pip$", "", key)
    return "" if name == key else _MODULES.get(name, name.replace("-", "_"))


def _remedy(key: str) -> str:
    name = re.sub(r"^python3?-|-pip$", "", key)
    if name == key:
        return remedy(key)
    return f"'pip install {PIP.get(_module(key), name)}' may bring it"
