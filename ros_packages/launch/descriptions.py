"""Descriptions of what an action runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from launch.substitution import SomeSubstitutionsType, normalize_to_list_of_substitutions


@dataclass(kw_only=True)
class Executable:
    """A program with its arguments and its surroundings."""

    cmd: Iterable[SomeSubstitutionsType]
    prefix: SomeSubstitutionsType | None = None
    name: SomeSubstitutionsType | None = None
    cwd: SomeSubstitutionsType | None = None
    env: Mapping[Any, SomeSubstitutionsType] | None = None
    additional_env: Mapping[Any, SomeSubstitutionsType] | None = None
    arguments: Iterable[SomeSubstitutionsType] | None = None

    def __post_init__(self) -> None:
        self.__prefix = normalize_to_list_of_substitutions(self.prefix or ())
