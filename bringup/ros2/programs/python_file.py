"""`ros2 run FILE.py`: a file of Python, with its `main()` where the file itself never calls it."""

from __future__ import annotations

import ast
import runpy
import sys
from pathlib import Path

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.remedies import remedy_of_module

_DEFINES = (ast.Import, ast.ImportFrom, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def run_file(path: Path, words: list[str]) -> None:
    """Run a file as `python FILE` does, then its `main()` if it has one that it does not call.

    The words are the program's own and ROS's, which rclpy reads from `sys.argv`.

    Raises:
        Ros2Error: It cannot be run, or lacks a module.
    """
    try:
        tree = ast.parse(read_text(path), str(path))
    except InputFileError as error:
        raise Ros2Error(str(error)) from error
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Ros2Error(f"{path}: is no Python: {error}") from error
    wants_main = has_uncalled_main(tree)
    if not wants_main and only_defines(tree):
        names = [item.name for item in tree.body if isinstance(item, _DEFINES[2:])]
        raise Ros2Error(
            f"{path} defines {', '.join(names) or 'nothing'} and calls none of it;"
            " give it a main(), which is called"
        )
    sys.argv = [str(path), *words]
    sys.path.insert(0, str(path.parent.resolve()))
    try:
        names_after = runpy.run_path(str(path), run_name="__main__")
        if wants_main:
            names_after["main"]()
    except ModuleNotFoundError as error:
        cure = remedy_of_module(error.name or "")
        raise Ros2Error(f"{path}: the module {error.name} is not installed; {cure}") from error


def has_uncalled_main(tree: ast.Module) -> bool:
    """Return whether a module defines `main` and no statement of its top level calls it."""
    functions = [item.name for item in tree.body if isinstance(item, ast.FunctionDef)]
    rest = [item for item in tree.body if not isinstance(item, _DEFINES)]
    nodes = (node for item in rest for node in ast.walk(item))
    called = any(isinstance(node, ast.Name) and node.id == "main" for node in nodes)
    return "main" in functions and not called


def only_defines(tree: ast.Module) -> bool:
    """Return whether a module calls nothing on its top level."""
    rest = [item for item in tree.body if not isinstance(item, _DEFINES)]
    return not any(isinstance(node, ast.Call) for item in rest for node in ast.walk(item))
