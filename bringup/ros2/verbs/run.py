"""`ros2 run`: a program of a package, or a file of Python."""

from __future__ import annotations

import importlib
import os
import re
import shlex
import shutil
import sys
from pathlib import Path
from typing import NoReturn

from arjuna_core.errors import nearest
from arjuna_core.files.input_file import head_of
from bringup.ros2.errors import Ros2Error
from bringup.ros2.prefix import add_prefix
from bringup.ros2.programs.python_file import run_file
from bringup.ros2.verbs.forward import (
    PROGRAMS,
    TAKES_ALL,
    executables_of,
    remedy,
    ros_arguments,
)


def below(prefix: list[str], words: list[str]) -> None:
    """Become a program that runs another, as a debugger does; without one, do nothing.

    Raises:
        Ros2Error: It is not installed.
    """
    ours = [sys.executable, "-m", "bringup.ros2.main", "run"]
    if prefix and not shutil.which(prefix[0]):
        raise Ros2Error(f"--prefix: there is no program '{prefix[0]}'")
    if prefix:
        os.execvp(prefix[0], [*prefix, *ours, *words])  # noqa: S606 - what the user asked for


def run(words: list[str]) -> int:
    """Run a program of a package, or a file of Python, below a `--prefix` where one is given."""
    option, sign, prefix = "".join(words[:1]).partition("=")
    if option == "--prefix" and len(words) > 2:
        prefix, words = (prefix, words[1:]) if sign else (words[1], words[2:])
        below(shlex.split(prefix), words)
    if not words or words[0] in ("-h", "--help"):
        print(
            "usage: ros2 run [-h] [--prefix PREFIX] package_name executable_name ...\n"
            "       ros2 run FILE.py ...\n"
        )
        print("\n".join(f"  {package} {name}" for package, name in sorted(PROGRAMS)))
        return 0 if words else 2
    if words[0].endswith(".py"):
        add_prefix()  # a program asks for the packages that `ros2 pkg prefix` finds
        run_file(Path(words[0]), words[1:])
        return 0
    package, name = words[0], "".join(words[1:2])
    own = executables_of(package)
    if name in own:
        add_prefix()
        become(own[name], words[2:])
    if package not in {known for known, _ in PROGRAMS} and not own:
        valid = nearest(package, {known for known, _ in PROGRAMS})
        valid = f"{valid}; 'ros2 run FILE.py' runs a file; {remedy(package)}"
        raise Ros2Error(f"Package '{package}' not found; {valid}")
    if (package, name) not in PROGRAMS:
        valid = nearest(name, {*own, *(known for other, known in PROGRAMS if other == package)})
        raise Ros2Error(f"No executable found; {valid}")
    program = PROGRAMS[package, name]
    if isinstance(program, str):
        module, _, function = program.partition(":")
        given = words[2:] if module in TAKES_ALL else ros_arguments(words[2:]).own
        getattr(importlib.import_module(module), function or "main")(given)
    else:
        program(words[2:])
    return 0


def become(path: Path, words: list[str]) -> NoReturn:
    """Become a program; one of Python runs in this environment.

    Raises:
        Ros2Error: It is of ROS 1.
    """
    text = head_of(path, 65536)
    if text.startswith(b"#!") and re.search(rb"^[ \t]*(import|from)\s+rospy\b", text, re.MULTILINE):
        raise Ros2Error(
            f"{path} is of ROS 1 (it imports rospy); docs/coming-from-ros1.md has ROS 2's"
        )
    folder = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([folder, os.environ.get("PATH", os.defpath)])
    os.execv(path, [str(path), *words])  # noqa: S606 - what the user asked for
