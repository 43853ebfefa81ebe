"""Substitutions: configurations, paths, the environment, commands and expressions."""

from __future__ import annotations

import importlib
import os
import shlex
import shutil
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from arjuna_core.files.input_file import read_text
from launch.launch_context import LaunchContext
from launch.substitution import (
    SomeSubstitutionsType,
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch.substitution import SubstitutionFailure as SubstitutionFailure
from launch.substitution import TextSubstitution as TextSubstitution

_TEXTS = (str, os.PathLike, Substitution, list, tuple)


def is_true(text: str) -> bool:
    """Return whether a text is true or 1, rather than false or 0."""
    plain = text.strip().lower()
    if plain not in ("true", "1", "false", "0"):
        raise ValueError(f"'{text}' is neither true nor false; valid: true, false, 1, 0")
    return plain in ("true", "1")


class LaunchConfiguration(Substitution):
    """The value of a configuration."""

    def __init__(self, variable_name: SomeSubstitutionsType, *, default: Any = None) -> None:
        name = normalize_to_list_of_substitutions(variable_name)
        self.variable_name = self.__variable_name = name
        parts: Any = default if isinstance(default, list | tuple) else [default]
        named: list[Any] = [part if isinstance(part, _TEXTS) else str(part) for part in parts]
        self.default = None if default is None else named

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.variable_name)
        if name in context.launch_configurations:
            return str(context.launch_configurations[name])
        if self.default is None:
            raise SubstitutionFailure(
                f"launch configuration '{name}' does not exist; DeclareLaunchArgument('{name}')"
                f" makes it, set here: {', '.join(sorted(context.launch_configurations)) or 'none'}"
            )
        return perform_substitutions(context, self.default)

    def __eq__(self, other: object) -> EqualsSubstitution:  # type: ignore[override]
        return EqualsSubstitution(self, other)

    def __ne__(self, other: object) -> NotEqualsSubstitution:  # type: ignore[override]
        return NotEqualsSubstitution(self, other)

    __hash__ = object.__hash__


class EnvironmentVariable(Substitution):
    """The value of a variable of the environment."""

    def __init__(
        self, name: SomeSubstitutionsType, *, default_value: SomeSubstitutionsType | None = None
    ) -> None:
        self.name, self.default_value = name, default_value

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        if name in context.environment:
            return context.environment[name]
        if self.default_value is None:
            raise SubstitutionFailure(f"environment variable '{name}' is not set; export {name}=")
        return perform_substitutions(context, self.default_value)


class PathJoinSubstitution(Substitution):
    """The parts of a path joined; `/` appends one."""

    def __init__(self, substitutions: Iterable[SomeSubstitutionsType]) -> None:
        self.substitutions = self.__substitutions = list(substitutions)

    def perform(self, context: LaunchContext) -> str:
        parts = [perform_substitutions(context, one) for one in self.substitutions]
        return os.path.join(*parts) if parts else ""  # noqa: PTH118 - a text stays as it is

    def __truediv__(self, part: SomeSubstitutionsType) -> PathJoinSubstitution:
        return PathJoinSubstitution([*self.substitutions, part])


class PathSubstitution(PathJoinSubstitution):
    """A path that `/` appends to."""

    def __init__(self, path: SomeSubstitutionsType) -> None:
        super().__init__([path])


class PythonExpression(Substitution):
    """The value of an expression of Python."""

    def __init__(
        self,
        expression: SomeSubstitutionsType,
        python_modules: Iterable[SomeSubstitutionsType] = ("math",),
    ) -> None:
        self.expression, self.python_modules = expression, list(python_modules)

    def perform(self, context: LaunchContext) -> str:
        text = perform_substitutions(context, self.expression)
        names: dict[str, Any] = {}
        for each in self.python_modules:
            name = perform_substitutions(context, each)
            module = importlib.import_module(name)
            names |= {**(vars(module) if name == "math" else {}), name: module}
        try:
            return str(eval(text, {}, names))  # noqa: S307 - the launch file's own words
        except Exception as error:
            raise SubstitutionFailure(f"failed to evaluate '{text}': {error}") from error


class Command(Substitution):
    """The output of a command."""

    def __init__(
        self, command: SomeSubstitutionsType, *, on_stderr: SomeSubstitutionsType = "fail"
    ) -> None:
        self.command, self.on_stderr = command, on_stderr

    def perform(self, context: LaunchContext) -> str:
        words = shlex.split(perform_substitutions(context, self.command))
        try:
            done = subprocess.run(  # noqa: S603 - the launch file's own words
                words, capture_output=True, text=True, check=True, timeout=120.0
            )
        except (OSError, subprocess.SubprocessError) as error:
            said = str(getattr(error, "stderr", "") or error).strip()
            raise SubstitutionFailure(f"'{' '.join(words)}' failed: {said}") from error
        wanted = perform_substitutions(context, self.on_stderr)
        if done.stderr and wanted == "fail":
            problem = f"'{' '.join(words)}' wrote to standard error: {done.stderr.strip()}"
            raise SubstitutionFailure(f"{problem}; on_stderr='ignore' allows it")
        return done.stdout + (done.stderr if wanted == "capture" else "")


class FindExecutable(Substitution):
    """The path of a program."""

    def __init__(self, *, name: SomeSubstitutionsType) -> None:
        self.name = name

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        found = shutil.which(name, path=context.environment.get("PATH"))
        if found is None:
            raise SubstitutionFailure(f"executable '{name}' not found on the PATH")
        return found


class ThisLaunchFile(Substitution):
    """The path of the launch file."""

    def perform(self, context: LaunchContext) -> str:
        found = getattr(context.locals, "current_launch_file_path", None)
        if found is None:
            raise SubstitutionFailure("ThisLaunchFile is used outside of a launch file")
        return str(found)


class ThisLaunchFileDir(ThisLaunchFile):
    """The folder of the launch file."""

    def perform(self, context: LaunchContext) -> str:
        return os.path.dirname(super().perform(context))  # noqa: PTH120 - a text


class LaunchLogDir(Substitution):
    """The folder of the run's log files."""

    def perform(self, context: LaunchContext) -> str:
        from launch.logging import launch_config

        return launch_config.log_dir


class FileContent(Substitution):
    """The text of a file."""

    def __init__(self, path: SomeSubstitutionsType) -> None:
        self.path = path

    def perform(self, context: LaunchContext) -> str:
        return read_text(Path(perform_substitutions(context, self.path)))


class AnonName(Substitution):
    """A name, made unique for the run; the same for the same name."""

    def __init__(self, name: SomeSubstitutionsType) -> None:
        self.name = name

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        made = f"{name}_{os.uname().nodename}_{os.getpid()}_{id(context)}"
        return str(context.launch_configurations.setdefault(f"anon{name}", made.replace("-", "_")))


class LocalSubstitution(Substitution):
    """Value that an action or an event has left in the context: `event.exitcode`, for example."""

    def __init__(self, expression: str, description: str | None = None) -> None:
        self.expression = expression

    def perform(self, context: LaunchContext) -> str:
        value: Any = context.locals
        for name in self.expression.split("."):
            value = getattr(value, name)
        return str(value)


AnyLocalSubstitution = LocalSubstitution


class _Logic(Substitution):
    """A substitution that is "true" or "false"."""

    decide: Callable[..., bool]

    def __init__(self, *values: Any) -> None:
        self.values = values

    def perform(self, context: LaunchContext) -> str:
        texts = (
            perform_substitutions(context, v if not isinstance(v, bool | int | float) else str(v))
            for v in self.values
        )
        try:
            return str(type(self).decide(*texts)).lower()
        except ValueError as error:
            raise SubstitutionFailure(f"{type(self).__name__}: {error}") from error


class NotSubstitution(_Logic):
    """`true` where a value is false."""

    decide = staticmethod(lambda value: not is_true(value))


class AllSubstitution(_Logic):
    """`true` where all values are true."""

    decide = staticmethod(lambda *values: all(map(is_true, values)))


class AnySubstitution(_Logic):
    """`true` where one of some values is true."""

    decide = staticmethod(lambda *values: any(map(is_true, values)))


AndSubstitution, OrSubstitution = AllSubstitution, AnySubstitution


class BooleanSubstitution(_Logic):
    """A value as `true` or `false`."""

    decide = staticmethod(is_true)


class EqualsSubstitution(_Logic):
    """`true` where two values are the same text, number or truth."""

    decide = staticmethod(lambda left, right: _plain(left) == _plain(right))


class NotEqualsSubstitution(_Logic):
    """`true` where two values differ."""

    decide = staticmethod(lambda left, right: _plain(left) != _plain(right))


def _plain(text: str) -> float | str:
    """Return a text as what it is compared by: a number, `true`, `false`, or itself."""
    if text.lower() in ("true", "false"):
        return text.lower()
    try:
        return float(text)
    except ValueError:
        return text


class IfElseSubstitution(Substitution):
    """One of two values, by a condition."""

    def __init__(
        self,
        condition: SomeSubstitutionsType,
        if_value: SomeSubstitutionsType = "",
        else_value: SomeSubstitutionsType = "",
    ) -> None:
        self.condition, self.values = condition, (else_value, if_value)

    def perform(self, context: LaunchContext) -> str:
        chosen = is_true(perform_substitutions(context, self.condition))
        return perform_substitutions(context, self.values[chosen])
