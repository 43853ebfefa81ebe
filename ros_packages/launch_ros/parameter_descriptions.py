"""Parameters of nodes: values, files, and what launching makes of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml
from launch.launch_context import LaunchContext
from launch.logging import get_logger
from launch.missing import left_out
from launch.substitution import (
    SomeSubstitutionsType,
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    found_here,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch.texts import parse_substitution

from arjuna_core.files.input_file import read_text
from arjuna_core.files.yaml_file import plain as plain_values

SomeParameters = Iterable[Any]
_TYPES = {"str": str, "int": int, "float": float, "bool": bool}
_SUBSTITUTED = re.compile(r"\$\([\w-]+[^()]*(?:\([^()]*\)[^()]*)*\)")


class ParameterValue:
    """A value, of a type where one is given."""

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self.value, self.value_type = value, value_type

    def evaluate(self, context: LaunchContext) -> Any:
        return value_of(context, self.value, self.value_type, typed=True)


class Parameter(ParameterValue):
    """A value with a name."""

    def __init__(
        self, name: SomeSubstitutionsType, value: Any, *, value_type: Any = None, **unused: Any
    ) -> None:
        super().__init__(value, value_type=value_type)
        self.name = name


class ParameterFile:
    """A file of parameters, whose `$(...)` may be replaced."""

    def __init__(
        self,
        param_file: SomeSubstitutionsType,
        *,
        allow_substs: bool | SomeSubstitutionsType = False,
    ) -> None:
        self.param_file = normalize_to_list_of_substitutions(param_file)
        self.allow_substs = allow_substs

    def evaluate(self, context: LaunchContext) -> Path:
        path = Path(perform_substitutions(context, self.param_file))
        allowed = self.allow_substs
        if not isinstance(allowed, bool):
            allowed = perform_substitutions(context, allowed).lower() in ("true", "1")
        if not allowed:
            return path

        def replaced(match: re.Match[str]) -> str:
            return perform_substitutions(context, parse_substitution(match[0]))

        return context.new_file(_SUBSTITUTED.sub(replaced, read_text(path)))


def value_of(context: LaunchContext, value: Any, kind: Any = None, typed: bool = False) -> Any:
    """Return a parameter's value; texts that substitutions make are read as YAML.

    Args:
        kind: The type it must have; None for what it is.
        typed: Whether a plain text is read as YAML too.
    """
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    several = isinstance(value, list | tuple)
    if isinstance(value, Substitution) or (
        several and any(isinstance(part, Substitution) for part in value)  # these make it one text
    ):
        value, typed = perform_substitutions(context, value), True
    elif several:
        return _uniform([value_of(context, one) for one in value])
    value = found_here(value) if isinstance(value, str) else value
    kind = _TYPES.get(kind, kind) if isinstance(kind, str) else kind
    if not isinstance(value, str) or kind is str or not (typed or kind):
        return value if kind is None else kind(value)
    found: Any = value
    with suppress(yaml.YAMLError):
        found = plain_values(value)
    plain = isinstance(found, str) and value[:1] not in ("'", '"')
    if plain or found is None or isinstance(found, Mapping):
        return value  # a robot's description may look like a mapping, and keeps its lines
    if kind in (int, float, bool):
        return kind(found)
    return _uniform(found) if isinstance(found, list) else found


def _uniform(values: list[Any]) -> list[Any]:
    """Return numbers of which some are floats as floats: a list of ROS has one type."""
    kinds = {type(value) for value in values}
    return [float(value) for value in values] if kinds == {int, float} else values


def normalize_parameters(given: Iterable[Any]) -> tuple[Any, ...]:
    """Return parameters as files and as mappings by names' substitutions, of sections with dots."""
    return tuple(
        _flattened(one)
        if isinstance(one, Mapping)
        else (one if isinstance(one, Parameter | ParameterFile) else ParameterFile(one))
        for one in given
    )


def _flattened(
    values: Mapping[Any, Any], before: tuple[Substitution, ...] = ()
) -> dict[tuple[Substitution, ...], Any]:
    found: dict[tuple[Substitution, ...], Any] = {}
    for key, value in values.items():
        name = (*before, *normalize_to_list_of_substitutions(key))
        if isinstance(value, Mapping):
            found |= _flattened(value, (*name, TextSubstitution(text=".")))
        else:
            found[name] = value
    return found


def evaluated(context: LaunchContext, one: Any) -> Path | dict[str, Any]:
    """Return parameters that were normalized: the path of a file, or values by name."""
    if isinstance(one, ParameterFile):
        return one.evaluate(context)
    given = {one.name: one} if isinstance(one, Parameter) else one
    names = {perform_substitutions(context, name): value for name, value in given.items()}
    return {name: value_of(context, value) for name, value in names.items()}


def files_of(context: LaunchContext, given: Iterable[Any], node: str) -> list[str]:
    """Return files of the parameters of a node, or `/**`: those given, and new ones of values.

    Of those that are not there it is said so.

    Raises:
        SubstitutionFailure: One is of a package that is not there.
    """
    found: list[str] = []
    for one in normalize_parameters(given):
        values = evaluated(context, one)
        if isinstance(values, dict):
            text = yaml.safe_dump({node: {"ros__parameters": values}}, sort_keys=False)
            found.append(str(context.new_file(text)))
        elif values.is_file():
            found.append(str(values))
        elif left_out(values):
            raise SubstitutionFailure(f"there is no parameter file {values}")
        else:
            get_logger("launch_ros").warning(f"Parameter file path is not a file: {values}")
    return found
