"""Expanding xacro macros, where a robot's file has them."""

from __future__ import annotations

import contextlib
import importlib
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from arjuna_core.errors import RobotError

_MARK = b"xmlns:xacro"


def has_macros(path: Path, text: bytes) -> bool:
    """Tell whether a robot's file has to be expanded."""
    return path.suffix == ".xacro" or (_MARK in text and (b"<xacro:" in text or b"${" in text))


def expand(path: Path, text: bytes) -> bytes:
    """Expand a robot's macros, all arguments at their defaults.

    `$(find package)` is the folder of this name among the folders above the file or beside them,
    else the folder above the file's own.

    Args:
        path: The file.
        text: Its content.

    Returns:
        The URDF.

    Raises:
        RobotError: It cannot be expanded.
    """
    try:
        xacro = importlib.import_module("xacro")
    except ImportError as error:
        problem = "has xacro macros, and the package xacro is not installed; a plain URDF is valid"
        raise RobotError(path, problem) from error
    _refuse_entities(path, text)
    expected = (xacro.XacroException, ExpatError, OSError, LookupError, ValueError, TypeError)
    quiet = io.StringIO()
    try:
        with _find_beside(path), contextlib.redirect_stderr(quiet):
            document: Any = xacro.process_file(str(path))
    except (*expected, _substitution_error()) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RobotError(path, f"xacro cannot expand it: {reason}") from error
    expanded: bytes = document.toprettyxml(indent="  ", encoding="utf-8")
    return expanded


def _substitution_error() -> type[Exception]:
    module = importlib.import_module("xacro.substitution_args")
    error: type[Exception] = module.SubstitutionException
    return error


def _refuse_entities(path: Path, text: bytes) -> None:
    """Keep entity bombs from xacro's own parser; other faults are its to report."""
    try:
        fromstring(text, forbid_dtd=True)
    except DefusedXmlException as error:
        problem = f"declares a DTD or entities ({type(error).__name__}); plain XML is valid"
        raise RobotError(path, problem) from error
    except (SyntaxError, ValueError, LookupError):
        return


@contextlib.contextmanager
def _find_beside(path: Path) -> Iterator[None]:
    """Let `$(find package)` look around the file instead of in a ROS installation."""
    module: Any = importlib.import_module("xacro.substitution_args")
    before: Callable[[str], str] = module._eval_find

    def find(package: str) -> str:
        parents = path.resolve().parents
        named = [p for p in parents if p.name == package] + [p / package for p in parents]
        return str(next((p for p in named if p.is_dir()), path.resolve().parent.parent))

    module._eval_find = find
    module._eval_dict["find"] = find
    try:
        yield
    finally:
        module._eval_find = before
        module._eval_dict["find"] = before
