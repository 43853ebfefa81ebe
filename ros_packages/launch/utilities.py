"""Functions for actions of one's own: texts of substitutions, and checks of types."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launch.action import entities as normalize_to_list_of_entities
from launch.substitution import normalize_to_list_of_substitutions, perform_substitutions

__all__ = [
    "ensure_argument_type",
    "is_a",
    "is_a_subclass",
    "normalize_to_list_of_entities",
    "normalize_to_list_of_substitutions",
    "perform_substitutions",
]


def is_a(obj: Any, entity_type: type[Any]) -> bool:
    return isinstance(obj, entity_type)


is_a_subclass = is_a


def ensure_argument_type(
    argument: Any, types: type[Any] | Iterable[type[Any]], argument_name: str, caller: str = ""
) -> None:
    """Raise a TypeError where an argument is of none of some types."""
    valid = (types,) if isinstance(types, type) else tuple(types)
    if not isinstance(argument, valid):
        names = ", ".join(each.__name__ for each in valid)
        of = f" of {caller}" if caller else ""
        raise TypeError(f"'{argument_name}'{of} is {argument!r}; valid: {names}")
