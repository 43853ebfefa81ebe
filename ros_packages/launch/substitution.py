"""Texts that are known only while launching."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Union

if TYPE_CHECKING:
    from launch.launch_context import LaunchContext


class SubstitutionFailure(RuntimeError):
    """A substitution has no value; the message says why."""


class Substitution:
    """A text that is known only while launching."""

    def describe(self) -> str:
        """Return it as text for people."""
        return f"{type(self).__name__}({', '.join(map(str, vars(self).values()))})"

    def __repr__(self) -> str:
        return self.describe()

    def perform(self, context: LaunchContext) -> str:
        """Return its value."""
        raise NotImplementedError


SomeSubstitutionsType = Union[
    str, "os.PathLike[str]", Substitution, Iterable[Union[str, Substitution]]  # noqa: UP007
]


class TextSubstitution(Substitution):
    """A text as it is."""

    def __init__(self, *, text: str) -> None:
        if not isinstance(text, str):
            raise TypeError(f"expected a text, got {text!r}")
        self.text = text

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
    return "".join(one.perform(context) for one in normalize_to_list_of_substitutions(subs))


def performed(context: LaunchContext, given: Mapping[Any, SomeSubstitutionsType]) -> dict[str, str]:
    """Return names and values that are texts or substitutions as texts."""
    return {
        perform_substitutions(context, name): perform_substitutions(context, value)
        for name, value in given.items()
    }
