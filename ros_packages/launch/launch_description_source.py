"""Sources of launch descriptions: files of Python, XML and YAML."""

from __future__ import annotations

import os
import runpy
from pathlib import Path
from typing import Any

from arjuna_core.files.input_file import is_xml
from launch.frontend import of_xml, of_yaml
from launch.launch_context import LaunchContext
from launch.launch_description import LaunchDescription
from launch.missing import without_missing
from launch.substitution import (
    SomeSubstitutionsType,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch.texts import InvalidLaunchFileError

_FUNCTION = "generate_launch_description"


class LaunchDescriptionSource:
    """A launch file, or a description as it is.

    Attributes:
        location: Path of the file, once it was read.
    """

    def __init__(
        self,
        launch_description: LaunchDescription | None = None,
        location: SomeSubstitutionsType = "",
    ) -> None:
        self.__launch_description = launch_description
        self.__location = normalize_to_list_of_substitutions(location)
        self.location = ""

    def try_get_launch_description_without_context(self) -> LaunchDescription:
        """Return the description, of a file whose path says no more than a new context knows."""
        return self.get_launch_description(LaunchContext())

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """Return the description; a file is read once."""
        self.location = self.location or perform_substitutions(context, self.__location)
        if self.__launch_description is None:
            path = Path(self.location)
            self.__launch_description = without_missing(context, lambda: description_of(path))
        return self.__launch_description


def description_of(path: Path) -> LaunchDescription:
    """Read a launch file: by its ending, else by how it begins."""
    if not os.path.lexists(path):
        beside = sorted(each.name for each in path.parent.glob("*") if each.is_file())
        there = f"; there are {', '.join(beside[:20])}" if beside else ""
        raise InvalidLaunchFileError(f"launch file {path} does not exist{there}")
    if path.suffix == ".py":
        return _of_python(path)
    if path.suffix in (".yaml", ".yml"):
        return of_yaml(path)
    return of_xml(path) if is_xml(path) else of_yaml(path)


def _of_python(path: Path) -> LaunchDescription:
    names: dict[str, Any] = runpy.run_path(str(path), run_name=path.name.partition(".")[0])
    if _FUNCTION not in names:
        raise InvalidLaunchFileError(f"launch file {path} has no function {_FUNCTION}()")
    found = names[_FUNCTION]()
    if not isinstance(found, LaunchDescription):
        raise InvalidLaunchFileError(
            f"{_FUNCTION}() of {path} returns {type(found).__name__}; valid: LaunchDescription"
        )
    return found
