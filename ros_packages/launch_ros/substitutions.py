"""Substitutions: packages' folders and executables, and parameters of the launch file."""

from __future__ import annotations

import os
from pathlib import Path

from ament_index_python import get_package_prefix, get_package_share_directory
from ament_index_python.packages import PackageNotFoundError as NotFound
from launch.launch_context import LaunchContext
from launch.missing import PackageMissing
from launch.substitution import (
    SomeSubstitutionsType,
    Substitution,
    SubstitutionFailure,
    perform_substitutions,
)
from launch.substitutions import PathJoinSubstitution

PackageNotFoundError = PackageMissing


class FindPackagePrefix(Substitution):
    """The folder where a package is installed; `/` appends to it."""

    find = staticmethod(get_package_prefix)

    def __init__(self, package: SomeSubstitutionsType) -> None:
        self.package = package

    def perform(self, context: LaunchContext) -> str:
        package = perform_substitutions(context, self.package)
        try:
            return str(self.find(package))
        except (NotFound, ValueError, LookupError) as error:
            raise PackageNotFoundError(package) from error

    def __truediv__(self, part: SomeSubstitutionsType) -> PathJoinSubstitution:
        return PathJoinSubstitution([self, part])


FindPackage = FindPackagePrefix


class FindPackageShare(FindPackagePrefix):
    """A package's share folder."""

    find = staticmethod(get_package_share_directory)


class ExecutableInPackage(FindPackagePrefix):
    """The path of a package's executable."""

    def __init__(self, executable: SomeSubstitutionsType, package: SomeSubstitutionsType) -> None:
        super().__init__(package)
        self.executable = executable

    def perform(self, context: LaunchContext) -> str:
        package = perform_substitutions(context, self.package)
        name = perform_substitutions(context, self.executable)
        folder = Path(super().perform(context)) / "lib" / package
        path = folder / name
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
        from arjuna_core.errors import nearest

        there = [each.name for each in folder.glob("*") if os.access(each, os.X_OK)]
        raise SubstitutionFailure(
            f"executable '{name}' of package '{package}' not found in {folder};"
            f" {nearest(name, there)}"
        )


class Parameter(Substitution):
    """The value of a parameter that the launch file has set for all nodes."""

    def __init__(
        self, name: SomeSubstitutionsType, *, default: SomeSubstitutionsType | None = None
    ) -> None:
        self.name, self.default = name, default

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        for values in reversed(context.launch_configurations.get("global_params", ())):
            if isinstance(values, dict) and name in values:
                return str(values[name])
        if self.default is None:
            raise SubstitutionFailure(f"parameter '{name}' is not set for all nodes")
        return perform_substitutions(context, self.default)
