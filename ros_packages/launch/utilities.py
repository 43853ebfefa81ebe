"""Functions for actions of one's own: texts of substitutions, and checks of types."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, get_args, get_origin

from arjuna_core.files.yaml_file import plain
from launch.action import entities as normalize_to_list_of_entities
from launch.launch_context import LaunchContext
from launch.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = [
    "coerce_to_type",
    "ensure_argument_type",
    "is_a",
    "is_a_subclass",
    "normalize_to_list_of_entities",
    "normalize_to_list_of_substitutions",
    "normalize_typed_substitution",
    "perform_substitutions",
    "perform_typed_substitution",
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


def coerce_to_type(value: str, data_type: Any = None) -> Any:
    """Return what a text says in YAML, of a type where one is given: `bool`, `List[int]`, ...

    Raises:
        ValueError: It is of another type.
    """
    if data_type is str:
        return value
    found = plain(value)
    kind, one = get_origin(data_type) or data_type, (*get_args(data_type), None)[0]
    parts = [found] if one is None else list(found) if isinstance(found, list) else []
    if float in (kind, one):
        parts = [float(part) if type(part) is int else part for part in parts]
    fits = parts and all(type(part) is (one or kind or type(part)) for part in parts)
    if not fits:
        raise ValueError(f"'{value}' is no {getattr(data_type, '__name__', data_type)}")
    return parts[0] if one is None else parts


def normalize_typed_substitution(value: Any, data_type: Any = None) -> Any:
    """Return a value as it is, substitutions that make one as a list."""
    plain_list = isinstance(value, list) and not any(isinstance(v, Substitution) for v in value)
    is_value = plain_list or isinstance(value, int | float | str)
    return value if is_value else normalize_to_list_of_substitutions(value)


def perform_typed_substitution(context: LaunchContext, value: Any, data_type: Any = None) -> Any:
    """Return a value as it is, or what substitutions make, of a type."""
    if not isinstance(value, list) or not any(isinstance(v, Substitution) for v in value):
        return value
    return coerce_to_type(perform_substitutions(context, value), data_type)
