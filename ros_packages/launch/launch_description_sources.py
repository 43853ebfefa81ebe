"""The sources of launch descriptions by the kind of file; each reads what the file is."""

from __future__ import annotations

from pathlib import Path

from launch.launch_context import LaunchContext
from launch.launch_description import LaunchDescription
from launch.launch_description_source import LaunchDescriptionSource
from launch.substitution import SomeSubstitutionsType
from launch.texts import InvalidLaunchFileError


class AnyLaunchDescriptionSource(LaunchDescriptionSource):
    """A launch file of any kind."""

    def __init__(self, launch_file_path: SomeSubstitutionsType) -> None:
        super().__init__(location=launch_file_path)


PythonLaunchDescriptionSource = FrontendLaunchDescriptionSource = AnyLaunchDescriptionSource
InvalidPythonLaunchFileError = InvalidLaunchFileError


def get_launch_description_from_any_launch_file(launch_file_path: str | Path) -> LaunchDescription:
    """Return the description that a launch file makes."""
    return AnyLaunchDescriptionSource(str(launch_file_path)).get_launch_description(LaunchContext())


get_launch_description_from_frontend_launch_file = get_launch_description_from_any_launch_file
get_launch_description_from_python_launch_file = get_launch_description_from_any_launch_file
