"""The sources of launch descriptions by the kind of file; each reads what the file is."""

from __future__ import annotations

from launch.launch_description_source import InvalidLaunchFileError, LaunchDescriptionSource
from launch.substitution import SomeSubstitutionsType

__all__ = [
    "AnyLaunchDescriptionSource",
    "FrontendLaunchDescriptionSource",
    "InvalidLaunchFileError",
    "PythonLaunchDescriptionSource",
]


class AnyLaunchDescriptionSource(LaunchDescriptionSource):
    """A launch file of any kind."""

    def __init__(self, launch_file_path: SomeSubstitutionsType) -> None:
        super().__init__(location=launch_file_path)


PythonLaunchDescriptionSource = FrontendLaunchDescriptionSource = AnyLaunchDescriptionSource
