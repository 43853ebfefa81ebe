"""Texts that are known only while launching."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Union

from ament_index_python import get_package_share_directory
from ament_index_python.packages import PackageNotFoundError

from launch.launch_context import LaunchContext
from launch.launch_context import Substitution as Substitution

_OF_ROS = re.compile(r"/opt/ros/\w+/share/([\w-]+)(?=/)")


class SubstitutionFailure(RuntimeError):
    """A substitution has no value; the message says why."""


SomeSubstitutionsType = Union[
    str, "os.PathLike[str]", Substitution, Iterable[Union[str, Substitution]]  # noqa: UP007
]
SomeSubstitutionsType_types_tuple = (str, os.PathLike, Substitution, Iterable)


class TextSubstitution(Substitution):
    """A text as it is."""

    def __init__(self, *, text: str) -> None:
        if not isinstance(text, str):
            raise TypeError(f"expected a text, got {text!r}")
        self.text = self.__text = text

    def perform(self, context: LaunchContext) -> str:
        return self.text


def normalize_to_list_of_substitutions(subs: SomeSubstitutionsType) -> list[Substitution]:
    """Return a text, a substitution, or several that make one text, as a list."""
    if isinstance(subs, Substitution):
        return [subs]
    if isinstance(subs, str | os.PathLike):
        return [TextSubstitution(text=os.fspath(subs))]
    if not isinstance(subs, Iterable):
        raise TypeError(f"expected a text or a substitution, or several, got {subs!r}")
    return [one for each in subs for one in normalize_to_list_of_substitutions(each)]


def perform_substitutions(context: LaunchContext, subs: SomeSubstitutionsType) -> str:
    """Return the value of a text, a substitution, or several that make one text."""
    values = [one.perform(context) for one in normalize_to_list_of_substitutions(subs)]
    return found_here("".join(values))


def found_here(text: str) -> str:
    """Return a text whose files of an installed ROS are those of the packages that are here."""
    return _OF_ROS.sub(_share, text) if "/opt/ros/" in text else text


def _share(match: re.Match[str]) -> str:
    try:
        is_there = Path(match[0]).is_dir()
        return match[0] if is_there else str(get_package_share_directory(match[1]))
    except PackageNotFoundError:
        return match[0]


def performed(context: LaunchContext, given: Mapping[Any, SomeSubstitutionsType]) -> dict[str, str]:
    """Return names and values that are texts or substitutions as texts."""
    return {
        perform_substitutions(context, name): perform_substitutions(context, value)
        for name, value in given.items()
    }
